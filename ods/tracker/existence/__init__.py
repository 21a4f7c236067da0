"""Does a track follow a real object? One model (evidence.c explains it), what it learns, and what follows from it."""
