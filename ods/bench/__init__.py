"""The hardware-in-the-loop bench: whole chain against the simulator, measured and judged."""
