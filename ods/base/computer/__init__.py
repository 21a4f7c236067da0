"""This process on its computer: memory, open files, load."""
