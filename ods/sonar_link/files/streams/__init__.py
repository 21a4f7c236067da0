"""Recordings that are a sonar's network stream as it came: Norbit, Oculus, Sonar 3D-15."""
