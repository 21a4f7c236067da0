"""The chain: its speed, false alarms, physical causes that are no objects, and the training of its network."""
