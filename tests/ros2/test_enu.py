"""Vectors computed by hand, and rotation matrices written down by their columns."""

import math

import numpy as np
import pytest

from ods.base.frames.geometry import quat_from_euler, rotation_matrix
from ods.base.frames.quaternion import rotated
from ods.ros2 import enu

A = math.sqrt(0.5)


def test_a_place_and_a_velocity() -> None:
    assert enu.enu((10.0, 20.0, 5.0)) == (20.0, 10.0, -5.0)
    assert enu.flu((1.0, 2.0, 3.0)) == (1.0, -2.0, -3.0)


@pytest.mark.parametrize(
    ("roll", "pitch", "heading", "by_hand"),
    [
        (0, 0, 0, (A, 0, 0, A)),  # level, to the north: 90 deg to port of east
        (0, 0, 90, (1, 0, 0, 0)),  # to the east
        (0, 0, 180, (A, 0, 0, -A)),  # to the south: 90 deg to starboard of east
        (0, 30, 90, (math.cos(math.pi / 12), 0, -math.sin(math.pi / 12), 0)),  # to the east, bow up: about port by -30
        (30, 0, 90, (math.cos(math.pi / 12), math.sin(math.pi / 12), 0, 0)),  # to the east, starboard down
    ],
)
def test_attitudes_by_hand(roll: float, pitch: float, heading: float, by_hand: tuple[float, ...]) -> None:
    w, x, y, z = quat_from_euler(*np.radians([roll, pitch, heading])).tolist()
    turned = np.array(enu.attitude((w, x, y, z)))
    assert turned * math.copysign(1.0, turned @ np.array(by_hand)) == pytest.approx(by_hand, abs=1e-12)


def test_what_the_vehicle_sees_is_at_the_same_place_of_the_world() -> None:
    w, x, y, z = quat_from_euler(0.1, -0.2, 2.0).tolist()
    seen = (30.0, -4.0, 2.0)
    in_ned = rotated((w, x, y, z), seen)
    assert rotated(enu.attitude((w, x, y, z)), enu.flu(seen)) == pytest.approx(enu.enu(in_ned), abs=1e-12)
    head = (0.9, 0.1, -0.3, 0.2)
    assert rotated(enu.mounting(head), enu.flu(seen)) == pytest.approx(enu.flu(rotated(head, seen)), abs=1e-12)


def test_the_fan_is_in_the_sonars_plane() -> None:
    columns = rotation_matrix(enu.FAN_TO_HEAD).T
    assert columns == pytest.approx(np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0]]), abs=1e-12)
    bearing, elevation = math.radians(30.0), math.radians(10.0)
    ahead, starboard, up = 0.98481 * 0.86603, 0.98481 * 0.5, 0.17365
    direction = rotated(enu.FAN_TO_HEAD, enu.fan(bearing, elevation))
    assert direction == pytest.approx((ahead, -starboard, up), abs=1e-5)


def test_uncertainty_goes_with_its_axes() -> None:
    assert enu.covariance((1.0, 2.0, 3.0), 0.5) == (4.0, 0.5, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 9.0)
