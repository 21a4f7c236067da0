"""The all-knowing arm: the fastest way among obstacles whose motions are all known, for a vehicle that can do so much."""
