"""From the data of the inertial navigation system, on CAN or as text, to poses."""
