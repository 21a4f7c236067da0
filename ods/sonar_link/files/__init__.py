"""Recorded sonar images: one decoder a format, and the writers of .npz and .s7k."""
