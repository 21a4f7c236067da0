"""Sonars of several planes: merges the echoes that adjacent planes have of the same object.

A body near the border of two planes is in the images of both. Range and bearing say the same twice, but which plane
receives it louder shows its elevation.
"""

import numpy as np

from ods.compiled import native
from ods.tracker.measurement.scan import Echoes

SIDE_LOBE_DB = 15.0
"""Level, dB, below which a second plane's echo may have come through side lobes, so that it shows no elevation."""


def merge_planes(echoes: Echoes, plane_half_rad: float) -> Echoes:
    """Return the echoes of one ping, each with its plane's half opening, and one where planes agree on a body.

    It is the loudest one, as all have the same errors of the same ping, with the largest radius. Its elevation is the
    mean of its plane's and the second loudest's, weighted by amplitude. With a share s of the weight in its own plane,
    the body is taken to be within s times `plane_half_rad` of that: half of it where both are equally loud.
    """
    made, kept = echoes.table.copy(), np.empty(len(echoes), np.bool_)
    loudest_first = np.argsort(-echoes.rows.strength, kind="stable")
    native.merge_planes(echoes.table, loudest_first, plane_half_rad, SIDE_LOBE_DB, made, kept)
    return Echoes(made).take(kept.nonzero()[0])
