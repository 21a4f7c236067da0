"""What commands share: their arguments, what a terminal shows, log lines."""
