"""False echoes: beams without information, other sonars, multipath, repeated images."""
