"""Pings to obstacle lists as on board, without sockets: files, scenes, and what came of them, scored and drawn."""
