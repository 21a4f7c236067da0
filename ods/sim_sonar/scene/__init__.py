"""What is where at any time."""
