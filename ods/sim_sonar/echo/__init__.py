"""The mean echo of objects: rays, reflection, shadows, beams."""
