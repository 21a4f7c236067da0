"""The user's files: which may be opened and written, configurations, presets, prints, macros."""
