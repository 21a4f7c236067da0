"""Speckle: its law, and the random numbers that it is made of."""
