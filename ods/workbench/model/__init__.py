"""State of the workbench and its actions, without widgets, files, clocks or threads."""
