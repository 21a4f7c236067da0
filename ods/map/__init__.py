"""The map of static objects for people and geographic software."""
