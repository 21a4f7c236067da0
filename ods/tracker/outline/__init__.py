"""What a circle does not say of objects: how long and wide they are, and where their nearest edge is."""
