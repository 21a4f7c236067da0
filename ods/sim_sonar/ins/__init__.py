"""The simulated INS and the CAN bus that it sends on."""
