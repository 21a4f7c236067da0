"""Frames of reference: rotations, attitudes, and where the sonar's head sits on the vehicle."""
