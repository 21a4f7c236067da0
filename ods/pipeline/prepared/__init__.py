"""The chain prepared for one geometry: planes, rings of attention, how frames are read, and the stages."""
