"""CAN frames from the inertial navigation system to poses."""
