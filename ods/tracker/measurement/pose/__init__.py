"""What the pose does to measurements: its noise, and motion while echoes come back."""
