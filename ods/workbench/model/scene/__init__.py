"""A scene as it is edited: its sliders, handles and effects, objects put in and taken out, its file's text."""
