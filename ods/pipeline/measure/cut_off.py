"""Echoes of which a part may lie where nothing is seen: beyond the fan's beams or ranges, or in beams without data."""

import numpy as np

from ods.compiled.kernel import kernel
from ods.pipeline.image.fill import is_one_beam_wide
from ods.pipeline.image.recorded import Recorded
from ods.pipeline.image.regions import Run, Runs
from ods.pipeline.measure.features import EchoRecord

_HIDDEN_M = 5.0
"""Standard deviation of the place of an object of which a part is hidden."""
_BEHIND_M = 1.5
"""Likewise along the range: of what the first or last range cuts off a middle is seen."""


@kernel
def is_cut_beside(recorded: Recorded, runs: Runs) -> bool:
    """Tell whether an echo reaches the fan's edge or beams without data; those that its neighbours fill are seen."""
    for i in range(runs.shape[0]):
        for beam in (runs[i].beam - 1, runs[i].beam + 1):
            if beam < 0 or beam >= recorded.samples.shape[0]:
                return True
            if recorded.missing.size and 2 * _hidden(recorded, beam, runs[i]) > runs[i].stop - runs[i].first:
                return True
    return False


@kernel
def _hidden(recorded: Recorded, beam: int, run: Run) -> int:
    """Return how many of the cells of a beam beside a run nobody sees."""
    count = 0
    for j in range(run.first, run.stop):
        column = recorded.origin[j]
        if recorded.missing[beam, column] and not is_one_beam_wide(recorded.missing, beam, column):
            count += 1
    return count


@kernel
def is_cut_in_range(runs: Runs, columns: int) -> bool:
    """Tell whether an echo reaches the nearest or the farthest range of the image, which has so many columns."""
    nearest, farthest = columns, 0
    for i in range(runs.shape[0]):
        nearest, farthest = min(nearest, runs[i].first), max(farthest, runs[i].stop)
    return nearest == 0 or farthest == columns


@kernel
def widen(echo: EchoRecord, beside: bool, in_range: bool) -> None:
    """Widen the standard deviations of an echo that is cut off beside, in range, or both.

    How far the object goes on nobody knows, and the error stays the same from ping to ping. What is cut beside shows
    its nearest point or one not much farther; of what is cut in range the middle is seen.
    """
    echo.sigma_range_m = np.hypot(echo.sigma_range_m, _BEHIND_M if in_range else echo.radius_m)
    if beside:
        echo.sigma_bearing_rad = np.hypot(echo.sigma_bearing_rad, _HIDDEN_M / max(echo.range_m, _HIDDEN_M))
    echo.sigma_radius_m = np.hypot(echo.sigma_radius_m, _HIDDEN_M)
