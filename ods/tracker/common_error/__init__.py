"""Errors of pose, mounting and sound speed, found from a common apparent motion of static objects."""
