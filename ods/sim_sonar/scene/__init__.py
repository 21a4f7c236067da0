"""The scene at any time: objects, vehicle, sea-bed."""
