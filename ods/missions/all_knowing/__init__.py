"""The all-knowing arm: the fastest way of a steered vehicle among obstacles whose motions are all known."""
