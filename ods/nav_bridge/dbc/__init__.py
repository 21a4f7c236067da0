"""A navigation system whose CAN frames a DBC file describes."""
