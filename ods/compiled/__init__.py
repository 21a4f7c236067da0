"""Kernels in C: how they are declared, built into one extension module, and called."""
