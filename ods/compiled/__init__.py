"""Kernels: compiled by numba, kept as machine code, and called on board without numba."""
