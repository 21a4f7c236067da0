"""Circles of echoes: are they and their standard deviations right, and the fit of the laws that give them."""
