"""Keys by which other computers and operators are known: files, lists of those allowed, and who may connect."""
