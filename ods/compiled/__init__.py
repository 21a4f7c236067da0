"""Kernels in C, in one extension module."""
