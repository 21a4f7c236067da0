"""Files that are read and written, whoever made them, and whose they are."""
