"""MOOS: polygons computed by hand, x to the east and y to the north; the datagram byte by byte."""

import math
import re

import pytest

from ods.bridge.moos import MoosEncoder, message
from ods.bridge.settings import MoosSettings
from ods.messages import Outline
from tests.bridge.moos_datagrams import read
from tests.bridge.samples import ENDED, ROCK, SWIMMER, UTC_NS, moment, obstacle

SETTINGS = MoosSettings(to="udp://127.0.0.1:9300")


def points(text: str) -> list[tuple[float, float]]:
    inside = re.match(r"pts=\{(.*)\},", text)
    assert inside
    return [(float(x), float(y)) for x, y in (pair.split(",") for pair in inside[1].split(":"))]


def test_a_datagram_is_what_pshare_reads() -> None:
    assert message("KEY", "ab", 1.5) == bytes.fromhex(
        "41000000" "ffffffff" "4e53"  # 65 bytes; no number; N: a notification, S: a text
        "03000000" "6f6473" "00000000" "03000000" "6f6473"  # from ods, nothing more, of the community ods
        "03000000" "4b4559" "000000000000f83f" "000000000000f0bf" "000000000000f0bf"  # key; 1.5 s; -1, -1
        "02000000" "6162"
    )  # fmt: skip


def test_polygons_hold_the_circle_and_its_uncertainty() -> None:
    encoded = MoosEncoder(SETTINGS).encode(moment(SWIMMER, ENDED, ROCK))
    rock, swimmer = map(read, encoded.datagrams)
    assert (rock.kind, rock.data_kind, rock.key, rock.time_s) == ("N", "S", "GIVEN_OBSTACLE", UTC_NS / 1e9 + 1.0)
    assert rock.text.endswith(",label=ods_7,vsource=ods,duration=2")
    # 2 m and twice the larger sigma, 0.4 m: sides at 2.8 m; x is east, y north
    corners = points(rock.text)
    assert corners[0] == pytest.approx((50.0 + 2.8 / math.cos(math.pi / 8.0), 100.0), abs=0.006)
    assert corners[2] == pytest.approx((50.0, 100.0 + 2.8 / math.cos(math.pi / 8.0)), abs=0.006)
    for (x, y), (x_next, y_next) in zip(corners, corners[1:] + corners[:1], strict=True):
        middle = math.hypot(0.5 * (x + x_next) - 50.0, 0.5 * (y + y_next) - 100.0)
        assert middle == pytest.approx(2.8, abs=0.01)
        assert (x - 50.0) * (y_next - 100.0) - (x_next - 50.0) * (y - 100.0) > 0.0  # convex, counter-clockwise
    centre = [sum(values) / 8.0 for values in zip(*points(swimmer.text), strict=True)]
    assert centre == pytest.approx([88.0, 110.0], abs=0.01)  # a second later, 2 m farther west


def test_a_slanting_ellipse_counts_by_its_long_axis() -> None:
    # sigma 1 m north and east, covariance 0.6: along the diagonal sqrt(1 + 0.6)
    slanting = obstacle(1, 0.0, 0.0, sigma_position=(1.0, 1.0, 1.0), covariance_ne=0.6)
    (reported,) = map(read, MoosEncoder(SETTINGS).encode(moment(slanting)).datagrams)
    wanted = (2.0 + 2.0 * math.sqrt(1.6)) / math.cos(math.pi / 8.0)
    assert points(reported.text)[0] == pytest.approx((wanted, 0.0), abs=0.006)


def test_an_elongated_obstacle_is_its_strip_and_its_uncertainty() -> None:
    # 10 m and 1 m, both 0.8 m more, to the north-east; the strip's middle is 1 m north of the obstacle's place
    outline = Outline((101.0, 50.0), 10.0, 1.0, math.pi / 4.0, 0.3)
    wall = obstacle(1, 100.0, 50.0, sigma_position=(0.4, 0.1, 1.0), sigma_radius=0.0, outline=outline)
    (reported,) = map(read, MoosEncoder(SETTINGS).encode(moment(wall)).datagrams)
    corners = points(reported.text)
    root = math.sqrt(0.5)
    assert corners[0] == pytest.approx((50.0 + root * (10.8 + 1.8), 101.0 + root * (10.8 - 1.8)), abs=0.006)
    assert corners[2] == pytest.approx((50.0 - root * (10.8 + 1.8), 101.0 - root * (10.8 - 1.8)), abs=0.006)
    turns = [
        (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
        for a, b, c in zip(corners, corners[1:] + corners[:1], corners[2:] + corners[:2], strict=True)
    ]
    assert min(turns) > 0.0  # convex, counter-clockwise


def test_only_the_nearest_are_sent() -> None:
    encoder = MoosEncoder(MoosSettings(to=SETTINGS.to, most_obstacles=1, duration_s=0.5, sigmas=0.0))
    encoded = encoder.encode(moment(SWIMMER, ROCK))
    (reported,) = map(read, encoded.datagrams)
    assert reported.text.endswith("label=ods_7,vsource=ods,duration=0.5")
    assert encoded.left_out == 1
