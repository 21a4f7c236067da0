"""Reading, writing and ownership of files."""
