"""The simulated sonar: geometry, timing, beam patterns."""
