"""Assignment of echoes to objects, chosen by `tracker.association`."""
