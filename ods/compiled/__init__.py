"""Kernels: the loops over arrays that numpy would be too slow for, in C; `native` calls them (kernel.h says how)."""
