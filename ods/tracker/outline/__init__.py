"""Outlines of objects beyond the circle: length, width and nearest edge."""
