from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ods.base.arrays import Bytes
from ods.messages import Detection, Detections, Ping, Sector
from ods.plots import fan
from ods.plots.polar import level_db
from tests.pipeline.pings import fan_bearings, make_ping


def pixel(raster: fan.Raster, x: float, y: float) -> tuple[int, int]:
    left, right, bottom, top = raster.extent
    rows, columns = raster.level.shape
    return int((y - bottom) / (top - bottom) * rows), int((x - left) / (right - left) * columns)


def test_picture_is_a_fan_with_starboard_right_and_ahead_up() -> None:
    bearings = fan_bearings(60)
    level = np.repeat(np.arange(60, dtype=np.float32)[:, None], 2000, axis=1)
    raster = fan.rasterize(fan.PolarImage(level, bearings, 0.0, 0.05))
    assert raster.extent == pytest.approx((-70.7, 70.7, 0.0, 100.0), abs=0.2)
    for beam in (0, 13, 30, 59):
        place = pixel(raster, 60.0 * np.sin(bearings[beam]), 60.0 * np.cos(bearings[beam]))
        assert raster.level[place] == beam
    assert np.isnan(raster.level[pixel(raster, -60.0, 10.0)])
    assert np.isnan(raster.level[pixel(raster, -70.0, 99.0)])


@pytest.mark.parametrize(("beam", "sample"), [(0, 0), (7, 40), (100, 333), (255, 1999), (128, 1234)])
def test_no_bright_sample_is_lost_or_misplaced(beam: int, sample: int) -> None:
    bearings = fan_bearings(256)
    level = np.zeros((256, 2000), np.float32)
    level[beam, sample] = 50.0
    raster = fan.rasterize(fan.PolarImage(level, bearings, 1.0, 0.05), pixels=300)
    row, column = np.nonzero(raster.level == 50.0)
    assert len(row)
    left, right, bottom, _ = raster.extent
    size = (right - left) / raster.level.shape[1]
    x, y = left + (column + 0.5) * size, bottom + (row + 0.5) * size
    distance = 1.0 + 0.05 * sample
    off = np.hypot(x - distance * np.sin(bearings[beam]), y - distance * np.cos(bearings[beam]))
    assert off.max() < 2.0 * size + 0.5 * distance * (bearings[1] - bearings[0])


def test_level_of_every_scale() -> None:
    counts = np.array([[0, 100]], np.uint8)
    np.testing.assert_allclose(level_db(make_ping(counts, scale="db", scale_factor=0.3)), [[0.0, 30.0]])
    np.testing.assert_allclose(level_db(make_ping(counts, scale="log8", scale_factor=40.0)), [[0.0, 50.0]])
    linear = level_db(make_ping(counts))
    np.testing.assert_allclose(linear, 20.0 * np.log10([[0.5, 100.5]]), rtol=1e-5)
    assert np.isfinite(level_db(make_ping(np.zeros((1, 2), np.float32)))).all()


def detections(*found: Detection) -> Detections:
    return Detections(
        seq=0,
        ping_number=1,
        t_ns=0,
        t_rx_ns=0,
        utc_ns=0,
        sound_speed=1500.0,
        sector=Sector(0.0, 100.0, -0.8, 0.8, 0.17),
        detections=list(found),
    )


def detection(**changes: float) -> Detection:
    fields: dict[str, Any] = dict.fromkeys(Detection.__struct_fields__, 0.1) | {"cells": 5} | changes
    return Detection(**fields)


def noise(shape: tuple[int, int]) -> Bytes:
    return np.random.default_rng(0).integers(0, 200, shape).astype(np.uint8)


@pytest.mark.parametrize(
    "ping",
    [
        make_ping(noise((48, 500)), bearing_rad=np.linspace(-0.13, 0.13, 48).tolist()),
        make_ping(noise((60, 300))),
        make_ping(noise((1, 50)), bearing_rad=[0.2]),
        make_ping(noise((8, 1))),
        make_ping(noise((20, 90)), bearing_rad=np.linspace(-3.0, 3.0, 20).tolist()),
        make_ping(np.zeros((6, 40), np.uint8), planes=3, bearing_rad=[-0.1, 0.1] * 3),
    ],
)
def test_pictures_of_all_kinds_of_fans(ping: Ping, tmp_path: Path) -> None:
    figure = fan.ping_figure(ping, detections(detection(range_m=1.0), detection(range_m=0.2, bearing_rad=-0.1)))
    figure.savefig(tmp_path / "fan.png")
    assert (tmp_path / "fan.png").stat().st_size > 5000
    axes = figure.axes[0]
    assert axes.get_title() == "ping 77: 2 detections"
    assert "m" in axes.get_xlabel()


def test_circles_are_where_the_detections_are() -> None:
    figure, axes = fan.new_figure("circles", fan_bearings(60))
    fan.draw_detections(axes, [detection(range_m=50.0, bearing_rad=0.3, radius_m=3.0)])
    (circle,) = axes.patches
    x, y = circle.get_center()  # type: ignore[attr-defined]
    assert (x, y) == pytest.approx((50.0 * np.sin(0.3), 50.0 * np.cos(0.3)))
    assert circle.get_radius() == 3.0  # type: ignore[attr-defined]
    assert figure.axes == [axes]
