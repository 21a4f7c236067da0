"""Which echo is whose, chosen by `tracker.association`."""
