"""The time of the navigation system: its clock mapped onto ours, its UTC, and which UTC counts."""
