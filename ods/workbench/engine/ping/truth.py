"""Detections against the truth of a ping: which are right, which are false, and which objects were missed."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.frames.geometry import body_to_polar, global_to_body
from ods.base.frames.mounting import Mounting
from ods.messages import Detection, Detections, Truth
from ods.workbench.engine.ping.compare import matched


class TrueCircle(NamedTuple):
    """A true object as the sonar's head has it."""

    name: str
    range_m: float
    """Slant range of its centre."""
    bearing_rad: float
    radius_m: float
    in_sector: bool
    """The sonar can see it."""


class Judged(NamedTuple):
    """Places in the lists of detections and of true circles."""

    right: list[tuple[int, int]]
    """Of the detection and of the object that it stands for."""
    more: list[int]
    """Other detections of an object that is found: neither right nor false."""
    false: list[int]
    missed: list[int]
    """Objects in the sector, at ranges that were processed, that no detection stands for."""


def true_circles(truth: Truth, mounting: Mounting) -> list[TrueCircle]:
    """Return the true objects of a ping."""
    if not truth.objects:
        return []
    head, turn, _ = mounting.head(truth.position_ned, truth.attitude)
    places = global_to_body([item.position_ned for item in truth.objects], head, turn)
    range_m, bearing, _ = body_to_polar(places)
    return [
        TrueCircle(item.name, at_m, towards, item.radius_m, item.in_sector)
        for item, at_m, towards in zip(truth.objects, range_m.tolist(), bearing.tolist(), strict=True)
    ]


def judged(detections: Detections, circles: Sequence[TrueCircle]) -> Judged:
    """Match detections with true objects whose circles overlap in the sonar's plane, one to one, those that overlap
    most first. What overlaps an object that has its detection already is `more`, as in `ods assess detect`."""
    found = detections.detections
    places, true_places = _in_plane(found), _in_plane(circles)
    radii, true_radii = _radii(found), _radii(circles)
    told = matched(places, radii, true_places, true_radii)
    apart = np.linalg.norm(places[:, None, :] - true_places[None, :, :], axis=-1)
    touches = (apart <= radii[:, None] + true_radii[None, :]).any(axis=1)
    return Judged(
        told.both,
        [place for place in told.only_a if touches[place]],
        [place for place in told.only_a if not touches[place]],
        [place for place in told.only_b if circles[place].in_sector and _processed(detections, circles[place])],
    )


def _processed(detections: Detections, circle: TrueCircle) -> bool:
    ranges = detections.processed_ranges_m
    return not ranges or any(near_m <= circle.range_m <= far_m for near_m, far_m in ranges)


def _in_plane(circles: Sequence[Detection] | Sequence[TrueCircle]) -> Floats:
    """Return (n, 2) centres ahead and to starboard, m: elevations are not resolved."""
    rows = np.array([(each.range_m, each.bearing_rad) for each in circles], np.float64).reshape(-1, 2)
    return np.stack([rows[:, 0] * np.cos(rows[:, 1]), rows[:, 0] * np.sin(rows[:, 1])], axis=-1)


def _radii(circles: Sequence[Detection] | Sequence[TrueCircle]) -> Floats:
    return np.array([each.radius_m for each in circles], np.float64)
