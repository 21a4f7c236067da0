"""Bytes from the sonar (serial line, TCP, files) to pings."""
