"""Bytes from the sonar, or of files, to pings."""
