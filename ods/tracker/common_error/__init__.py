"""Errors of pose, mounting and sound speed, from objects at rest that all seem to move alike."""
