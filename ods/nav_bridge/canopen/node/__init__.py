"""Our own CANopen node beside the navigation system: its objects, errors and network."""
