"""Data between the stages of the chain: samples, images, regions, and the fan that they lie in."""
