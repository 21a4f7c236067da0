"""The simulated INS and the line that it sends on."""
