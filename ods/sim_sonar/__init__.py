"""Scenes to sonar pings and vehicle pose: the simulated SeaBat and the simulated vehicle."""
