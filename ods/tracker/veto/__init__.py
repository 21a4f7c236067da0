"""Operators' vetoes: which obstacles may be ignored, and who may say so."""
