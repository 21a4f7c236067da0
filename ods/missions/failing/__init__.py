"""Worlds, sonars and INSs that nothing was tuned on: where methods fail, and whether the list said so."""
