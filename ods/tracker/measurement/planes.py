"""Sonars of several planes: the echoes that planes next to each other have of the same body become one.

A body near the border of two planes is in the images of both. Range and bearing say the same twice, but which plane
hears it louder tells at what elevation it is.
"""

import math

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.compiled.kernel import kernel
from ods.tracker.measurement.model import wrapped
from ods.tracker.measurement.scan import Echoes, EchoRows, echo_rows

AGREE_SIGMAS = 3.0
"""Ranges and bearings that differ by no more than this, in standard deviations of the difference, are those of one
body."""
SIDE_LOBE_DB = 15.0
"""What is so much less loud in a second plane may have come through that plane's side lobes: it tells no elevation."""
TOUCHING = 1.0 + 1e-6
"""Planes whose openings overlap or touch are next to each other; this allows for rounding."""


def one_a_body(echoes: Echoes, plane_half_rad: float) -> Echoes:
    """Return the echoes of one ping, each with its plane's half opening, and one where planes agree on a body.

    It is the loudest one, as all have the same errors of the same ping, with the largest radius. Its elevation is the
    mean of its plane's and the second loudest's, weighted by amplitude. With a share s of the weight in its own plane,
    the body is taken to be within s times `plane_half_rad` of that: half of it where both are equally loud.
    """
    table, kept = _one_a_body(echoes.table, plane_half_rad)
    return Echoes(table).take(kept.nonzero()[0])


@kernel
def _one_a_body(table: Floats, plane_half_rad: float) -> tuple[Floats, Mask]:
    """Return the (12, m) table with bodies' echoes put together, and (m,) which of them remain."""
    result = table.copy()
    echoes, made = echo_rows(table), echo_rows(result)
    made.half_vertical[:] = plane_half_rad
    kept, reach = np.ones(table.shape[1], np.bool_), 2.0 * plane_half_rad * TOUCHING
    loudest_first = np.argsort(-echoes.strength, kind="mergesort")
    for k, i in enumerate(loudest_first):
        if not kept[i]:
            continue
        alone = True
        for j in loudest_first[k + 1 :]:
            if not (kept[j] and _same_body(echoes, i, j, reach)):
                continue
            louder_db = echoes.strength[i] - echoes.strength[j]
            if alone and louder_db < SIDE_LOBE_DB:
                share = 1.0 / (1.0 + 10.0 ** (-louder_db / 20.0))
                made.elevation[i] = share * echoes.elevation[i] + (1.0 - share) * echoes.elevation[j]
                made.half_vertical[i] = share * plane_half_rad
            if echoes.radius[j] > made.radius[i]:
                made.radius[i], made.sigma_radius[i] = echoes.radius[j], echoes.sigma_radius[j]
            kept[j] = alone = False
    return result, kept


@kernel
def _same_body(echoes: EchoRows, i: int, j: int, reach: float) -> bool:
    """Tell whether two echoes are of planes next to each other, and agree."""
    apart = abs(echoes.elevation[i] - echoes.elevation[j])
    if not 0.0 < apart <= reach:
        return False
    longer = abs(echoes.range_m[i] - echoes.range_m[j])
    aside = abs(wrapped(echoes.bearing[i] - echoes.bearing[j]))
    return longer <= AGREE_SIGMAS * math.hypot(echoes.sigma_range[i], echoes.sigma_range[j]) and (
        aside <= AGREE_SIGMAS * math.hypot(echoes.sigma_bearing[i], echoes.sigma_bearing[j])
    )
