"""A navigation system that speaks CANopen: its PDOs and services, and our own node beside it."""
