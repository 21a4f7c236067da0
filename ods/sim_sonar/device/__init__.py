"""The live devices of the bench, and the line of the sonar."""
