"""Real processes on real sockets and lines: what they cost, and an hour of faults."""
