"""The table of tracks and their life: existence, states, stitching."""
