"""Hardware in the loop: the whole chain against the simulator."""
