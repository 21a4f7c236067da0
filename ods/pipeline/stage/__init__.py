"""Stages: their register, their settings, and the data of each ping that they get."""
