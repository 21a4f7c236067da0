"""The workbench in a real browser: its speed and memory, and the pictures of its docs."""
