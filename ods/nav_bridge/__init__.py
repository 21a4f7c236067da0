"""INS data, on CAN or as text, to poses."""
