"""From regions to echoes: place, size and uncertainty."""
