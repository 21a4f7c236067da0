"""A reference planner: obstacle list and clearance in, set points out. For benches and missions, not for a vehicle."""
