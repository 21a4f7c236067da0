"""A scene: its plan, image and curves, its file, and a rehearsal of its mission."""
