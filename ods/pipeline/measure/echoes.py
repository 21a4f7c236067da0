"""From regions to echoes: levels, extents, near edge, and the circle that stands for each object."""

import math
from collections.abc import Sequence
from pathlib import Path
from struct import Struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats, Image, Mask
from ods.compiled import native
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.measure.sigmas.features import Features
from ods.pipeline.stage.params import NotANumberError

ECHO = np.dtype(
    [
        ("range_m", np.float64),
        ("bearing_rad", np.float64),
        ("radius_m", np.float64),
        ("peak", np.float64),
        ("mean", np.float64),
        ("snr_db", np.float64),
        ("cells", np.int64),
        ("range_extent_m", np.float64),
        ("bearing_extent_rad", np.float64),
        ("sigma_range_m", np.float64),
        ("sigma_bearing_rad", np.float64),
        ("sigma_radius_m", np.float64),
        ("amplitude", np.float64),
        ("elevation_rad", np.float64),
        ("near_m", np.float64),
        ("sigma_near_m", np.float64),
        ("cut", np.bool_),
        ("onset", np.float64),
        ("front", np.float64),
        ("half_length_m", np.float64),
        ("half_width_m", np.float64),
        ("axis_rad", np.float64),
    ],
    align=True,
)
"""One echo: the fields of `ods.messages.Detection`, in its order, but for the last ones, of range images only."""

ROW = Struct("6dq9d?7x5d")
"""The same, as bytes are unpacked by: three times as fast as `tolist`."""

EchoTable = NDArray[np.void]
"""(regions,) of ECHO."""

SIGMA_NETWORK = Path(__file__).parent / "sigmas" / "laws.npz"
"""Of the standard deviations of circles (sigmas.h), by `python -m benchmarks.circles.laws`."""
with np.load(SIGMA_NETWORK) as _arrays:
    _LAWS = tuple(_arrays[name] for name in ("sigmas_hidden", "sigmas_out", "range_hidden", "range_out"))
NO_ECHOES: EchoTable = np.empty(0, ECHO)


def joined(tables: Sequence[EchoTable]) -> EchoTable:
    """Return one table of all rows."""
    if len(tables) == 1:
        return tables[0]
    filled = [table for table in tables if table.size]
    return np.concatenate(filled) if filled else NO_ECHOES


class Wanted(NamedTuple):
    """Which echoes of an image count."""

    from_m: float
    """Ranges from here"""
    to_m: float
    """to less than this."""
    least_front: float
    """What is faint has to have a likelier `front`."""


def split_faint(echoes: EchoTable, faint: Mask | None, wanted: Wanted) -> tuple[EchoTable, EchoTable]:
    """Return the echoes that are wanted, and the faint ones; faint: (echoes,), None: none is."""
    out, counts = np.empty(len(echoes), ECHO), np.empty(2, np.int64)
    marks = np.zeros(len(echoes), np.bool_) if faint is None else faint
    native.part_echoes(echoes, marks, wanted, out, counts)
    strong, weak = counts.tolist()
    return out[:strong], out[strong : strong + weak]


class Measured(NamedTuple):
    """The echoes of an image, and the features from which their standard deviations follow."""

    echoes: EchoTable
    features: Floats
    """(regions, features) in the order of `Features`."""
    point: float
    """Width of a point along the line of sight, columns."""


def measure_echoes(image: Image, regions: Regions, recorded: Recorded, fan: Fan) -> EchoTable:
    """Return the echoes of the regions that were found in image (beams, samples), which has the geometry `fan`.

    `front` is not reported yet. Raises NotANumberError.
    """
    return measure(image, regions, recorded, fan).echoes


def measure(image: Image, regions: Regions, recorded: Recorded, fan: Fan) -> Measured:
    """Return the same, with the features of each echo. Raises NotANumberError."""
    echoes, features = np.zeros(regions.total, ECHO), np.zeros((regions.total, len(Features._fields)))
    point = native.measure_echoes(image, regions.runs, regions.background, recorded, fan.table, _LAWS, echoes, features)
    if math.isnan(point):
        raise NotANumberError
    return Measured(echoes, features, point)
