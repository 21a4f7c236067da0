"""The circle that stands for an object: its depth, its outline, and the smallest circle around points."""
