"""The background of an image: its level, noise, tail and crests, and the levels that follow from them."""
