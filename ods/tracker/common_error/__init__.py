"""Errors of pose, mounting and sound speed, from static objects that all seem to move alike."""
