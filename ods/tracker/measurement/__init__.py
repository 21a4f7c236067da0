"""Measurements of a scan: echoes in the world, the sonar's field of view, motion while echoes come back."""
