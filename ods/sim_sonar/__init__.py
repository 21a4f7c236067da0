"""Scenes to pings and poses: simulated sonars, INSs and vehicle."""
