"""Shared parts of commands: arguments, terminal output, log lines."""
