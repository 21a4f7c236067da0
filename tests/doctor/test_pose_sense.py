"""Poses that cannot be right: another site, depth reported as height, a velocity in another unit or other axes."""

import math
from collections.abc import Sequence

import msgspec
import pytest

from ods.base import clock
from ods.base.clock import NS
from ods.doctor.pose_sense import examine
from ods.messages import Pose


def straight(
    place: Sequence[float], velocity_ned: Sequence[float], told_body: Sequence[float], yaw: float, seconds: float = 3.0
) -> list[Pose]:
    """Return poses at 100 Hz of a vehicle that moves straight on and tells `told_body` as its velocity."""
    attitude = math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)
    poses = []
    for number in range(round(100 * seconds)):
        north, east, down = (p + v * number / 100 for p, v in zip(place, velocity_ned, strict=True))
        t_ns = number * 10_000_000
        u, v, w = told_body
        poses.append(Pose(number, t_ns, t_ns, (north, east, down), attitude, (u, v, w), (0.5,) * 3, (0.005,) * 3))
    return poses


@pytest.mark.parametrize(
    ("place", "east", "reported", "said"),
    [
        ((100.0, 200.0, 20.0), 1.5, (1.5, 0.0, 0.0), []),
        ((0.0, 0.0, 20.0), 0.0, (0.0, 0.0, 0.0), []),
        ((15_000.0, 0.0, 20.0), 1.5, (1.5, 0.0, 0.0), []),
        ((40_000.0, 30_000.0, 20.0), 1.5, (1.5, 0.0, 0.0), ["50.0 km from the site"]),
        ((0.0, 0.0, -20.0), 1.5, (1.5, 0.0, 0.0), ["20.0 m above the surface"]),
        ((0.0, 0.0, -1.0), 1.5, (1.5, 0.0, 0.0), []),
        ((0.0, 0.0, 20.0), 1.5, (5.4, 0.0, 0.0), ["is the velocity in km/h?"]),
        ((0.0, 0.0, 20.0), 0.5, (1.8, 0.0, 0.0), ["is the velocity in km/h?"]),
        ((0.0, 0.0, 20.0), 2.0, (3.888, 0.0, 0.0), ["is the velocity in knots?"]),
        ((0.0, 0.0, 20.0), 1.5, (0.0, 1.5, 0.0), ["are the units and axes of velocity, attitude"]),
        ((0.0, 0.0, 20.0), 1.5, (1.2, 0.2, 0.0), []),
    ],
)
def test_what_cannot_be_right_is_wrong_and_nothing_else(
    place: Sequence[float], east: float, reported: Sequence[float], said: list[str]
) -> None:
    found = list(examine("navigation", straight(place, (0.0, east, 0.0), reported, 0.5 * math.pi)))
    assert [item.level for item in found] == ["wrong"] * len(said)
    assert all(words in item.text for item, words in zip(found, said, strict=True))


@pytest.mark.parametrize("synchronized", [True, False])
def test_a_time_that_is_another_one_may_be_a_line_that_is_behind(
    synchronized: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clock, "synchronized", lambda: synchronized)
    poses = straight((0.0, 0.0, 20.0), (1.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0)
    assert not list(examine("navigation", [msgspec.structs.replace(pose, utc_source="clock") for pose in poses]))
    found = list(examine("navigation", [msgspec.structs.replace(pose, utc_source="unsure") for pose in poses]))
    assert [item.level for item in found] == ["note"] * synchronized


def test_a_gap_between_poses_is_not_taken_for_motion() -> None:
    poses = straight((0.0, 0.0, 20.0), (1.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0, 0.5)
    elsewhere = straight((500.0, 0.0, 20.0), (1.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0, 0.5)
    later = [msgspec.structs.replace(pose, t_ns=pose.t_ns + 60 * NS) for pose in elsewhere]
    assert not list(examine("navigation", poses + later))
