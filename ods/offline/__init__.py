"""Pings of files and scenes to obstacle lists as on board, scored and drawn."""
