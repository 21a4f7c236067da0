"""Computations for the pages of the workbench, without widgets."""
