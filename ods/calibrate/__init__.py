"""Mounting angles and latency of the sonar from a recording."""
