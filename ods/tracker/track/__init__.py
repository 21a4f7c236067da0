"""The table of tracks: history, existence, filters; stitching."""
