"""What the tracker leaves to its successor, and which ids are still free."""
