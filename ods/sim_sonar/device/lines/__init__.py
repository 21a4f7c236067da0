"""Far ends of lines: serial, TCP, UDP, multicast."""
