"""Many missions in random worlds, with the vehicle in the loop."""
