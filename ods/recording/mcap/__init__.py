"""Recordings as MCAP files: the messages of the bus as sent, written crash-safe and read with limits."""
