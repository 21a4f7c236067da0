"""Surfaces: how they reflect, and the echo of a plane."""
