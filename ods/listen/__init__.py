"""Topics for other computers: tcp with CURVE, an allow-list of keys, and who is revoked receives nothing more."""
