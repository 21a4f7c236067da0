"""A scene: its plan, image, curves and pings, its file, and a rehearsal of its mission."""
