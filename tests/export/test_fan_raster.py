"""Pixels of a fan, by where their places are on paper."""

import math

import msgspec
import numpy as np
import pytest

from ods.export.fan_raster import FanRaster
from tests.pipeline.pings import fan_bearings, make_ping

BEAMS, SAMPLES = 61, 400


def test_an_echo_is_where_it_is() -> None:
    rng = np.random.default_rng(5)
    counts = rng.integers(1, 40, (BEAMS, SAMPLES)).astype(np.uint8)
    counts[44:49, 296:305] = 255
    ping = make_ping(counts)
    raster = FanRaster()
    picture = raster.image(ping)
    bearing, range_m = ping.bearing_rad[46], ping.range0_m + 300 * ping.dr_m
    x, y = raster.pixel(range_m, bearing)
    assert picture[int(y), int(x)] == 255
    assert x > picture.shape[1] / 2  # starboard is to the right
    rows, columns = np.nonzero(picture == 255)
    assert (rows.mean(), columns.mean()) == pytest.approx((y, x), abs=4.0)
    far = ping.range0_m + (SAMPLES - 0.5) * ping.dr_m
    assert raster.metres_a_pixel == pytest.approx(2 * far * math.sin(ping.bearing_rad[-1]) / picture.shape[1], rel=0.03)


def test_what_is_not_of_the_fan_is_black_and_all_of_the_fan_is_not() -> None:
    counts = np.random.default_rng(5).integers(1, 200, (BEAMS, SAMPLES)).astype(np.uint8)
    picture = FanRaster().image(make_ping(counts))
    bearings = fan_bearings(BEAMS)
    share = np.count_nonzero(picture) / picture.size
    width = 2.0 * math.sin(bearings[-1])  # of a fan of radius 1: its sector, on its box
    assert share == pytest.approx((bearings[-1] - bearings[0]) / 2.0 / width, abs=0.03)
    assert (picture[-1, 0], picture[0, 0]) == (0, 0)


def test_shades_stay_while_the_setting_stays() -> None:
    rng = np.random.default_rng(6)
    raster = FanRaster()
    first = make_ping(rng.integers(10, 100, (BEAMS, SAMPLES)).astype(np.uint8))
    raster.image(first)
    brighter = raster.image(make_ping(np.full((BEAMS, SAMPLES), 99, np.uint8)))
    assert set(np.unique(brighter)) == {0, 255}
    other = msgspec.structs.replace(make_ping(np.full((BEAMS, SAMPLES), 99, np.uint8)), setting="gain 3")
    assert set(np.unique(raster.image(other))) == {0, 1}  # a drop-out of a setting not seen before


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_all_sample_types_draw_alike(dtype: type[np.generic]) -> None:
    counts = np.random.default_rng(7).integers(1, 250, (BEAMS, SAMPLES))
    plain = FanRaster().image(make_ping(counts.astype(np.uint16)))
    assert np.abs(FanRaster().image(make_ping(counts.astype(dtype))).astype(int) - plain).max() <= 40


@pytest.mark.parametrize(
    "changes",
    [{"data": b"1"}, {"planes": 2}, {"range0_m": -1e5}, {"bearing_rad": [0.0] * BEAMS}, {"bearing_rad": [0.0]}],
)
def test_what_is_no_fan_is_refused(changes: dict[str, object]) -> None:
    ping = make_ping(np.arange(BEAMS * SAMPLES, dtype=np.float32).reshape(BEAMS, SAMPLES))
    with pytest.raises(ValueError, match=r"fit|fan|hold"):
        FanRaster().image(msgspec.structs.replace(ping, **changes))


def test_an_echo_of_one_sample_is_seen() -> None:
    samples = 4000
    counts = np.random.default_rng(8).integers(1, 40, (BEAMS, samples)).astype(np.uint8)
    ping = make_ping(counts, dr_m=0.01)
    raster = FanRaster()
    raster.image(ping)  # shades
    for at in range(3000, 3007):
        counts[30] = 1
        counts[30, at] = 255
        picture = raster.image(make_ping(counts, dr_m=0.01))
        x, y = raster.pixel(at * 0.01, ping.bearing_rad[30])
        around = picture[int(y) - 1 : int(y) + 2, int(x) - 2 : int(x) + 3]
        assert around.max() == 255
