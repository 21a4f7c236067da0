"""Pictures; only commands off board draw."""
