"""What the inertial navigation system sends, on CAN or as text, to poses."""
