"""Recordings of what a running chain publishes."""
