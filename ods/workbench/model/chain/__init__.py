"""The chain of stages as it is edited, and the numbers that follow from the smallest object."""
