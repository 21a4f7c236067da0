"""Existence of tracks: the probability model (explained in evidence.c), its statistics, and the life cycle."""
