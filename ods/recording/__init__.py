"""`ods record`: what a running chain publishes, as a file."""
