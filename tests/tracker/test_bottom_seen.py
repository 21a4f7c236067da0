"""The bottom from where its echo sets in: against rays that meet a plane."""

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.geometry import quat_from_euler, rotation_matrix
from ods.messages import BottomEcho, Detections, Sector
from ods.runtime.pose_buffer import PoseEstimate
from ods.tracker.map.map_object import MapObject
from ods.tracker.output.bottom import may_be_hit
from ods.tracker.output.bottom_seen import KEPT_S, RELATIVE, BottomKnown, bottom_seen
from ods.tracker.output.snapshot import snapshot_of_map
from ods.tracker.settings import BottomSettings

BELOW = math.radians(11.5)
BEARING = np.radians(np.linspace(-40.0, 40.0, 10))
PLACE = np.array([100.0, -40.0, 30.0])


def head(roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> PoseEstimate:
    sigmas = np.full(3, 0.1), np.full(3, 0.002), 0.0
    return PoseEstimate(0, PLACE, quat_from_euler(roll, pitch, yaw), np.zeros(3), *sigmas)


def rays(pose: PoseEstimate) -> Floats:
    """Return (10, 3) unit vectors of the fan's lower side."""
    body = [[math.cos(BELOW) * math.cos(b), math.cos(BELOW) * math.sin(b), math.sin(BELOW)] for b in BEARING]
    return np.array(body) @ rotation_matrix(pose.attitude).T


def echo_of(pose: PoseEstimate, height_m: float, normal: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> BottomEcho:
    """Return where the lower side meets a plane `height_m` below the head."""
    ranges = height_m * normal[2] / (rays(pose) @ normal)
    return BottomEcho(BEARING.tolist(), ranges.tolist(), BELOW)


@pytest.mark.parametrize("height_m", [2.0, 5.0, 10.0])
@pytest.mark.parametrize(
    ("roll", "pitch", "yaw"), [(0.0, 0.0, 0.0), (0.0, 0.1, 2.0), (0.05, -0.08, -1.0), (-0.1, 0.05, 0.5)]
)
def test_the_depth_of_a_level_bottom_is_exact_in_any_attitude(
    height_m: float, roll: float, pitch: float, yaw: float
) -> None:
    pose = head(roll, pitch, yaw)
    bottom = bottom_seen(echo_of(pose, height_m), pose, -100.0)
    assert bottom is not None
    assert bottom.place[2] == pytest.approx(PLACE[2] + height_m)
    there = np.mean(echo_of(pose, height_m).range_m * rays(pose).T, axis=1) + PLACE
    np.testing.assert_allclose(bottom.place, there)
    assert bottom.sigma_m >= RELATIVE * height_m


def test_a_slope_is_as_deep_as_where_it_is_seen() -> None:
    """It rises ahead by 5 degrees: right below it is 6 m deep, where it is seen 4.3."""
    pose, rise = head(), math.tan(math.radians(5.0))
    bottom = bottom_seen(echo_of(pose, 6.0, (rise, 0.0, 1.0)), pose, 0.0)
    assert bottom is not None
    ahead = bottom.place[0] - PLACE[0]
    assert bottom.place[2] - PLACE[2] == pytest.approx(6.0 - rise * ahead, abs=0.3)
    assert bottom.place[2] - PLACE[2] < 5.0


def test_what_may_be_the_surface_is_no_bottom() -> None:
    """At a depth of 6 m the upper side of the fan meets the surface where the lower one meets a bottom 6 m below."""
    pose = head()
    assert bottom_seen(echo_of(pose, 6.0), pose, PLACE[2] - 6.0) is None
    assert bottom_seen(echo_of(pose, 6.0), pose, PLACE[2] - 12.0) is not None
    up = head(pitch=math.radians(15.0))
    assert bottom_seen(echo_of(pose, 6.0), up, 0.0) is None


def test_groups_that_disagree_tell_nothing_and_single_ones_do_not_matter() -> None:
    pose = head()
    echo = echo_of(pose, 5.0)
    mixed = [r * s for r, s in zip(echo.range_m, [0.3, 3.0] * 5, strict=True)]
    assert bottom_seen(msgspec.structs.replace(echo, range_m=mixed), pose, 0.0) is None
    two_off = [8.0, 9.0, *echo.range_m[2:]]
    bottom = bottom_seen(msgspec.structs.replace(echo, range_m=two_off), pose, 0.0)
    assert bottom is not None
    assert bottom.place[2] == pytest.approx(PLACE[2] + 5.0)


def test_a_spread_of_the_groups_is_in_the_deviation() -> None:
    pose, echo = head(), echo_of(head(), 5.0)
    wild = [r * s for r, s in zip(echo.range_m, [0.8, 1.2] * 5, strict=True)]
    even, rough = (bottom_seen(msgspec.structs.replace(echo, range_m=r), pose, 0.0) for r in (echo.range_m, wild))
    assert even is not None
    assert rough is not None
    assert rough.sigma_m > math.hypot(even.sigma_m, 0.5)


def message(t_s: float, echo: BottomEcho | None) -> Detections:
    sector = Sector(0.0, 100.0, -0.8, 0.8, 0.17)
    return Detections(0, 0, round(t_s * NS), 0, 0, 1500.0, sector, [], bottom_echo=echo)


def test_the_poses_altitude_counts_first_and_what_was_seen_for_a_while() -> None:
    pose, known = head(), BottomKnown(0.0)
    told = replace(pose, altitude_m=7.0, sigma_altitude_m=0.2)
    assert known.at(NS, pose) is None
    known.hear(message(1.0, echo_of(pose, 5.0)), None)  # nobody knows where that was
    assert known.at(NS, pose) is None
    known.hear(message(1.0, echo_of(pose, 5.0)), pose)
    known.hear(message(2.0, None), pose)
    for vehicle, down in ((pose, 5.0), (None, 5.0), (told, 7.0)):
        bottom = known.at(2 * NS, vehicle)
        assert bottom is not None
        assert bottom.place[2] == pytest.approx(PLACE[2] + down)
    assert known.at(round((1.1 + KEPT_S) * NS), pose) is None


@pytest.mark.parametrize("error", [-0.2, 0.0, 0.15])
def test_what_sticks_up_is_not_called_bottom_though_the_height_is_wrong(error: float) -> None:
    """A pattern unlike the one taken makes the bottom seem 20 % too high: more than one standard deviation."""
    rng = np.random.default_rng(8)
    pose, top = head(), rng.uniform(1.0, 4.0, 4000)
    bottom = bottom_seen(echo_of(pose, 5.0 * (1.0 + error)), pose, 0.0)
    assert bottom is not None
    for sigma in (0.1, 0.5, 2.0):
        down = PLACE[2] + 5.0 - 0.5 * top + rng.normal(0.0, sigma, len(top))
        stones = snapshot_of_map(
            [
                MapObject(i + 1, (120.0, -40.0, float(d)), (0.1, 0.1, sigma), 0.5, 0.1, 0.99, 9, 1, 2, 3)
                for i, d in enumerate(down)
            ]
        )
        left_out = ~may_be_hit(stones, bottom, BottomSettings())
        assert left_out.mean() <= BottomSettings().risk
