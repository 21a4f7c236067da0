"""What the workbench shows and what can be done to it, without widgets, files, clocks or threads."""
