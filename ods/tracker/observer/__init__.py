"""Filters of an object's state, chosen by `tracker.observer`."""
