"""The states of an object [SSIE figure 5] and what leads from one to the next.

TENTATIVE -> ACTIVE                 proved by echoes (before that no list has it)
TENTATIVE -> TERMINATED             not proved
ACTIVE    -> STAND_BY               out of view, or silent, or unseen until its place is not known: time updates only
STAND_BY  -> ACTIVE                 seen again
STAND_BY  -> HIBERNATED             out of view too long, not moving: into the map
STAND_BY  -> TERMINATED             out of view too long, moving; or gone
HIBERNATED -> ACTIVE                found again
HIBERNATED -> TERMINATED            its place is in full view, and it is gone
"""

TENTATIVE, ACTIVE, STAND_BY, HIBERNATED, TERMINATED = range(5)
"""States of an object; ACTIVE to HIBERNATED are reported. The only changes there are lead along the arrows above."""
