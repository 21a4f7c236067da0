"""What a running chain publishes, as files."""
