"""Files that a process leaves in the run folder: its state for its successor, and why it ended."""
