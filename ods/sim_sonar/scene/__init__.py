"""What is where at any time: objects, vehicle, sea-bed."""
