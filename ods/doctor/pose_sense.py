"""Poses that hold together: near the site, under water, of the time that it is, and moving as fast as they say."""

import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from ods.base import clock
from ods.doctor.finding import Finding
from ods.messages import Pose
from ods.pose.motion import PoseMotion

FAR_M = 20_000.0
"""Distance from its origin at which the local frame's plane is 31 m above the sea's surface, m."""
HIGH_M = 5.0
"""Above the datum: more than waves, antennas and a quay account for."""


def examine(subject: str, poses: Sequence[Pose]) -> Iterator[Finding]:
    """Yield what cannot be right about the poses received, in order of time; at least one."""
    north, east, down = poses[-1].position_ned
    away_m = float(np.hypot(north, east))
    if away_m > FAR_M:
        fault = f"the vehicle is {away_m / 1000:.1f} km from the site: is [site] this mission's?"
        yield Finding("wrong", subject, fault)
    if down < -HIGH_M:
        fault = f"the vehicle is {-down:.1f} m above the surface: is it height instead of depth"
        cure = "sign = -1 in nav.dbc.signals, a negative factor in nav.canopen.objects"
        yield Finding("wrong", subject, f"{fault} ({cure})?")
    if poses[-1].utc_source == "unsure" and clock.synchronized():
        fault = "the INS's time is more than 1 s from this computer's, which is synchronized"
        why = "it is wrong, or its data arrive late, for example through a serial server that buffers"
        yield Finding("note", subject, f"{fault}: {why}")
    yield from _motion(subject, poses)


def _motion(subject: str, poses: Sequence[Pose]) -> Iterator[Finding]:
    """Compare the change of place with the velocity, where poses came for long enough."""
    motion = PoseMotion()
    for first, second in itertools.pairwise(poses):
        motion.add(first, second)
    if differs := motion.disagreement():
        yield Finding("wrong", subject, differs)
