"""Tuning in a browser [SSIE]."""
