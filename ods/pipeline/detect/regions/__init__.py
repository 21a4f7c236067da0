"""Regions: cells above a level grown together, split, and selected."""
