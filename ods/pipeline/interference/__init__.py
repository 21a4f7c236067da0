"""What is no echo of a body: beams that receive nothing, other sonars, multipath, an image that repeats."""
