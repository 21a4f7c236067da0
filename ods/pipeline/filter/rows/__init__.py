"""Windows in C that filters and detectors share: blocks of samples, rows of an image, its mirrored range ends."""
