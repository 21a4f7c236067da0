"""Restart of a tracker: checkpoints of its state, and ids that are never reused."""
