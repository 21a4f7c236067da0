"""The vehicle's pose at any instant, that of the sonar's head, and whether poses hold together."""
