"""Tuning in a browser [SSIE]: parameters, chain, picture, and the file that runs on board."""
