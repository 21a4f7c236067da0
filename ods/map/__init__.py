"""The map of objects at rest, for people: `ods map` and files for geographic software."""
