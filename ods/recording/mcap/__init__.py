"""Recordings as MCAP files: what was on the bus, bytes as on the wire, written crash-safe and read with bounds."""
