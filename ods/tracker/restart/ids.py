"""Ids of new objects: none is given twice, whatever is lost."""

import secrets

PROVISIONAL_IDS = 0x4000_0000
ABOVE_ALL = 2 * PROVISIONAL_IDS
"""From here on ids are those given while the map could not be read; they do not show which ordinary ones are free. All
new ids fit in 32 bits, with a sign; maps of before have provisional ones up to 2^53."""
MOST_A_MISSION = 0x10_0000
"""No mission gives more provisional ids."""
ID_BLOCK = 1000
"""Number of ids reserved on disk at a time."""


def provisional_first_id() -> int:
    """Return where ids begin while those of the map are not known: where no other mission's ids are, but for a chance
    of 2e-6 for another that began like that, if both give a thousand."""
    return PROVISIONAL_IDS + secrets.randbelow(ABOVE_ALL - PROVISIONAL_IDS - MOST_A_MISSION)


def first_of(of_map: int, of_former: int) -> int:
    """Return where ids begin once those of the map are known; `of_former`: from here on a former tracker gave none. If
    it knew of provisional ones only, they do not go on."""
    return of_map if of_former >= PROVISIONAL_IDS else max(of_map, of_former)


def reserved_id(next_id: int) -> int:
    """Return where the ids of a tracker begin that takes over from one that was killed: it may have given some after
    what it left last, where `next_id` is the next one; at least half a block of them."""
    return -(-(next_id + ID_BLOCK // 2) // ID_BLOCK) * ID_BLOCK
