"""The map of static objects, for people: `ods map` and files for geographic software."""
