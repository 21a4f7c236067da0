"""The generic objects: where rays meet them, what they look like from the sonar, what they hide."""
