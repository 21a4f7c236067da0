"""What a tracker leaves to the next one: checkpoints of its state, and ids that are never given twice."""
