"""Fields of static objects in view of the sonar, of the sizes that scan steps are timed with."""

import msgspec
import numpy as np

from ods.assess.track.case import Case, observe
from ods.assess.track.scenarios import SONAR, in_sector, world

SIZES = ((10, 12), (30, 42), (100, 150), (300, 320))
"""Objects in view, detections a scan."""
SETTLING, TIMED = 70, 350
"""Scans before the timing begins, and of it."""


def field(objects: int, detections: int) -> Case:
    """Return a field of static objects in view, with false alarms that make up the detections."""
    rng = np.random.default_rng(objects)
    meta = msgspec.structs.replace(SONAR, clutter_lambda=detections - SONAR.pd * objects)
    places = in_sector(rng, objects, 10.0, 98.0, 2.5)
    t = np.arange(SETTLING + TIMED) / 7.0
    scene = world(t, places, np.zeros_like(places), rng.uniform(0.3, 1.0, objects), 0.0, meta)
    return observe("field", scene, rng)
