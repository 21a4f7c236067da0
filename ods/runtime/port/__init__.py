"""Ports that may vanish and come back: serial lines, TCP connections, UDP ports."""
