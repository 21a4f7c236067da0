"""Labelled images: simulated, drawn, and labelled by eye."""
