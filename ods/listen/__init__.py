"""Topics for other computers: tcp with CURVE, and an allow-list of keys."""
