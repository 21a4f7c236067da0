"""Kernels in C: declared, built into one extension module, called."""
