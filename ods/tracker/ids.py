"""Which ids new objects get: none twice, whatever is lost."""

import secrets

PROVISIONAL_IDS = 1 << 40
"""From here on ids are those given while the map could not be read; they do not tell which ordinary ones are free."""
ID_BLOCK = 1000
"""Ids are reserved on disk by so many at a time."""


def provisional_first_id() -> int:
    """Return where ids begin while those of the map are not known: where no other mission's ids are, but for a chance
    of 1e-11. They stay below 2^53, so that planners may keep them as floating point numbers."""
    return PROVISIONAL_IDS + secrets.randbelow(1 << 52)


def reserved_id(next_id: int) -> int:
    """Return where the ids of a tracker begin that takes over from one that was killed: it may have given some after
    what it left last, where `next_id` is the next one; at least half a block of them."""
    return -(-(next_id + ID_BLOCK // 2) // ID_BLOCK) * ID_BLOCK
