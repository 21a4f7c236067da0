"""Echograms: levels, what is drawn over them, computed beside the page, and printed."""
