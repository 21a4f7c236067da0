"""Hibernated objects, in memory and in the map file."""
