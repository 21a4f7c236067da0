"""Ports that may vanish and come back: serial lines and TCP connections."""
