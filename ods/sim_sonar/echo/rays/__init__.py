"""Rays and beams: how many rays an object needs, and how columns of the fan become beams."""
