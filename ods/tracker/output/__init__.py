"""What the planner gets: snapshot, closest approach, obstacle list, validity."""
