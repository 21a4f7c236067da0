"""Poses that hold together: near the site, under water, and moving as fast as they say."""

import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.geometry import rotation_matrix
from ods.doctor.finding import Finding
from ods.messages import Pose

FAR_M = 20_000.0
"""So far from its origin the local frame's plane is 31 m above the sea's surface."""
HIGH_M = 5.0
"""Above the datum: more than waves, antennas and a quay account for."""
LONGEST_STEP_S = 1.0
"""Between two poses whose places are compared; a velocity tells little about more."""
SLACK_M, SLACK = 1.0, 0.3
"""Distances may differ by so much, and by this share of the longer one, beside the position's standard deviation."""
UNITS = {3.6: "km/h", 1.944: "knots", 3.281: "ft/s", 100.0: "cm/s", 1000.0: "mm/s"}
"""How many of each are one m/s."""
NEAR_UNIT = 0.1
"""Share by which the ratio of two distances may differ from one of UNITS."""


def examine(subject: str, poses: Sequence[Pose]) -> Iterator[Finding]:
    """Yield what cannot be right about the poses heard, in order of time; at least one."""
    north, east, down = poses[-1].position_ned
    away_m = float(np.hypot(north, east))
    if away_m > FAR_M:
        told = f"the vehicle is {away_m / 1000:.1f} km from the site: is [site] this mission's?"
        yield Finding("wrong", subject, told)
    if down < -HIGH_M:
        told = f"the vehicle is {-down:.1f} m up in the air: is height told, not depth"
        cure = "sign = -1 in nav.dbc.signals, a negative factor in nav.canopen.objects"
        yield Finding("wrong", subject, f"{told} ({cure})?")
    yield from _motion(subject, poses)


def _motion(subject: str, poses: Sequence[Pose]) -> Iterator[Finding]:
    """Compare the change of place with the velocity, where it was heard for long enough to tell."""
    moved, told, seconds = np.zeros(3), np.zeros(3), 0.0
    for first, second in itertools.pairwise(poses):
        step_s = (second.t_ns - first.t_ns) / NS
        if 0.0 < step_s <= LONGEST_STEP_S:
            moved += np.subtract(second.position_ned, first.position_ned)
            told += 0.5 * step_s * (_velocity(first) + _velocity(second))
            seconds += step_s
    moved_m, told_m = float(np.linalg.norm(moved)), float(np.linalg.norm(told))
    allowed_m = SLACK_M + max(poses[-1].sigma_position_ned) + SLACK * max(moved_m, told_m)
    if np.linalg.norm(moved - told) > allowed_m:
        yield Finding("wrong", subject, f"the position moved by {_vector(moved)} m within {seconds:.1f} s, by the "
                      f"velocity it were {_vector(told)} m (north, east, down): {_guess(moved_m, told_m)}")  # fmt: skip


def _velocity(pose: Pose) -> Floats:
    """Return the velocity in the local frame, m/s."""
    return np.asarray(rotation_matrix(pose.attitude) @ np.asarray(pose.velocity_body))


def _vector(vector: Floats) -> str:
    return ", ".join(f"{part:.1f}" for part in vector)


def _guess(moved_m: float, told_m: float) -> str:
    """Return what to look at."""
    for factor, unit in UNITS.items():
        if abs(told_m - factor * moved_m) < NEAR_UNIT * factor * moved_m:
            return f"is the velocity in {unit}?"
    return "are the units and axes of velocity, attitude and position right?"
