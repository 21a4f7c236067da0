"""Kalman filters of north and east: independent axes, and interacting models of motion."""
