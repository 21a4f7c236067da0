"""The pose of vehicle and sonar head at any instant, and whether poses are plausible."""
