"""A reference planner for benches and missions, not for a vehicle."""
