"""A step of UTC moves what was stamped since the start, and nothing of earlier missions; made-up clocks."""

import dataclasses

import numpy as np
import pytest

from ods.base.clock import NS
from ods.messages import Pose
from ods.pose.utc import VehicleUtc
from ods.tracker.map.map_object import MapObject
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.samples import RATE_HZ, scan

STARTED_NS = 5_000 * NS
WRONG, RIGHT = 0, 1_790_000_000 * NS
"""UTC when CLOCK_MONOTONIC is 0: a clock that was never set, and the right one."""
EARLIER = RIGHT - 86_400 * NS


def pose(t_ns: int, ahead_ns: int) -> Pose:
    zeros = (0.0, 0.0, 0.0)
    return Pose(0, t_ns, t_ns + ahead_ns, zeros, (1.0, *zeros), zeros, zeros, zeros, "ins")


def known(number: int, last_seen_utc_ns: int) -> MapObject:
    sigma = (1.0, 1.0, 1.0)
    return MapObject(number, (900.0, 0.0, 4.0), sigma, 1.0, 0.1, 1.0, 9, EARLIER, last_seen_utc_ns, last_seen_utc_ns)


@pytest.mark.parametrize(("before_ns", "after_ns"), [(WRONG, RIGHT), (RIGHT, RIGHT + 3600 * NS), (RIGHT, WRONG)])
def test_ages_stay_when_utc_steps(before_ns: int, after_ns: int) -> None:
    utc = VehicleUtc(STARTED_NS, before_ns, "unsure")
    seen_now = STARTED_NS + before_ns + NS
    tracker = Tracker(TrackerSettings(), [known(1, EARLIER), known(2, seen_now)], first_id=3)
    for k in range(20):
        t_ns = STARTED_NS + round(k / RATE_HZ * NS)
        seen = scan(k / RATE_HZ, np.array([0.0, 0.0, 4.0]), 0.0, [(40.0, 0.0, 1.0)])
        tracker.step(dataclasses.replace(seen, t_ns=t_ns, utc_ns=utc.at(t_ns)))
    utc.receive(pose(t_ns, after_ns))
    moved = utc.follow(t_ns)
    assert moved is not None
    assert moved.step_ns == after_ns - before_ns
    (changed,) = tracker.restamp(moved)
    assert (changed.id, changed.first_seen_utc_ns) == (2, EARLIER)
    snapshot = tracker.snapshot()
    ages = dict(zip(snapshot.id.tolist(), (utc.at(t_ns) - snapshot.last_seen_utc_ns).tolist(), strict=True))
    assert ages == {1: utc.at(t_ns) - EARLIER, 2: t_ns - STARTED_NS - NS, 3: 0}
    assert utc.source == "ins"
    assert utc.follow(t_ns) is None


def test_a_clock_that_is_slewed_is_followed_without_a_step() -> None:
    utc = VehicleUtc(STARTED_NS, RIGHT, "clock")
    for k in range(100):
        utc.receive(pose(STARTED_NS, RIGHT + k * NS // 10))
        assert utc.follow(STARTED_NS) is None
    assert utc.at(STARTED_NS) == STARTED_NS + RIGHT + 99 * NS // 10
