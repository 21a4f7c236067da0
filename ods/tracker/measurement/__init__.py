"""What a scan measures: echoes in the world, the sonar's field of view, motion while echoes come back."""
