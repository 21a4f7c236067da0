"""Echoes that reach the strongest of the recorded samples: equalization lifts what is nearly silent, and noise too."""

import numpy as np

from ods.base.arrays import Mask
from ods.compiled import native
from ods.pipeline.image.recorded import Recorded
from ods.pipeline.image.regions import Regions


def level_of_strongest(recorded: Recorded, share: float) -> float:
    """Return the level that this share of the recorded samples that hold data reaches; 0 where none does.

    Looked at are some of them, evenly spread, in steps that never fall in with the rows.
    """
    level: float = native.level_of_strongest(recorded, share)
    return level


def strong_as_recorded(recorded: Recorded, regions: Regions, level: float) -> Mask:
    """Return (total,) bool: regions with a recorded sample that reaches the level; all do, if that is 0 or less."""
    strong = np.empty(regions.total, np.bool_)
    native.strong_as_recorded(recorded, regions.runs, level, strong)
    return strong
