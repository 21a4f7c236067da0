"""Data of the INS, on CAN or as text, to poses."""
