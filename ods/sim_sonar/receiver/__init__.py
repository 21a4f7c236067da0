"""From echoes to samples: gain, speckle, noise, imperfections, quantization."""
