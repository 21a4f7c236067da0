"""Possible pairs of object and echo, and their scores against clutter."""
