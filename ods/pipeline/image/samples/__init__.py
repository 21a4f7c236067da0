"""Recorded samples: read as numbers, as linear amplitudes, and those that an image was made of."""
