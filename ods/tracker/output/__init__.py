"""Output to the planner: snapshot, closest approach, obstacle list, validity."""
