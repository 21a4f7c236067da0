"""The wheels, installed where nothing else is."""
