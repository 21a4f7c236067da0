"""Circles of simulated bodies: background 1, exponential speckle, Gaussian beams as wide as they are spaced."""

import numpy as np
import pytest

from ods.base.arrays import Floats, Floats32
from ods.messages import Detection
from ods.pipeline.chain import Chain
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import RUN, Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.measure.echoes import ECHO, measure_echoes
from ods.pipeline.settings import PipelineSettings
from tests.pipeline.pings import body_echo, fan_bearings, make_ping, speckle

BEARINGS = fan_bearings(60)


def errors(shape: str, radius: float, range_m: float, looks: int = 12) -> Floats:
    """Errors of radius, range and cross-range, m, of the default chain for a body 20 dB over the background.

    (looks, 3): the body at several bearings, so anywhere between two beams, and each time in other speckle.
    """
    rng = np.random.default_rng(42)
    chain = Chain(PipelineSettings())
    rows = []
    for bearing in np.linspace(-0.3, 0.31, looks):
        intensity = 1.0 + 100.0 * body_echo(shape, radius, range_m, bearing, BEARINGS, 2000)
        counts = np.rint(40.0 * np.log10(1.0 + 8.0 * speckle(rng, intensity))).astype(np.uint8)
        ping = make_ping(counts, scale="log8", scale_factor=40.0)
        found = chain.process(ping).detections
        assert 1 <= len(found) <= 3  # one image in twenty has a false alarm
        best = max(found, key=lambda detection: detection.cells)
        rows.append([best.radius_m - radius, best.range_m - range_m, (best.bearing_rad - bearing) * range_m])
    return np.array(rows)


@pytest.mark.parametrize(("radius", "range_m"), [(1.0, 12.0), (1.0, 25.0), (2.0, 35.0), (3.0, 75.0)])
def test_circle_through_the_near_half_of_a_body_is_the_body(radius: float, range_m: float) -> None:
    error = errors("half", radius, range_m)
    assert abs(error[:, 0].mean()) < 0.16 * radius
    assert abs(error[:, 1].mean()) < 0.2 * radius
    assert abs(error[:, 2].mean()) < 0.15
    assert np.sqrt((error[:, 2] ** 2).mean()) < 0.2 * 0.026 * range_m + 0.1  # a fifth of a beam


def test_width_of_the_beam_is_taken_out_of_small_bodies() -> None:
    error = errors("half", 0.5, 75.0)  # a beam is 2 m wide there: cells alone would make it 2.4 m
    assert abs(error[:, 0].mean()) < 0.4
    assert abs(error[:, 1].mean()) < 0.3


def test_whole_discs() -> None:
    error = errors("disc", 2.0, 30.0)
    assert abs(error[:, 0].mean()) < 0.2
    assert abs(error[:, 1].mean()) < 0.4


def test_flat_front_is_not_taken_for_a_round_one() -> None:
    error = errors("wall", 3.0, 35.0)
    assert abs(error[:, 0].mean()) < 0.3
    assert abs(error[:, 1].mean()) < 0.5


def strip_image(range_m: float, length: float, axis: float) -> tuple[Floats32, Floats, list[tuple[int, int, int, int]]]:
    """A strip 0.6 m wide about (range, 0), half `length` long: image, bearings, runs of its cells."""
    bearings = np.radians(np.linspace(-20.0, 20.0, 161))
    ranges = 10.0 + 0.1 * np.arange(400)
    x = ranges * np.cos(bearings)[:, None] - range_m
    y = ranges * np.sin(bearings)[:, None]
    along, beside = x * np.cos(axis) + y * np.sin(axis), y * np.cos(axis) - x * np.sin(axis)
    inside = (np.abs(along) <= length) & (np.abs(beside) <= 0.3)
    image = np.where(inside, 8.0, 1.0).astype(np.float32)
    runs = [
        (beam, int(np.flatnonzero(row)[0]), int(np.flatnonzero(row)[-1]) + 1, 1)
        for beam, row in enumerate(inside)
        if row.any()
    ]
    return image, bearings, runs


@pytest.mark.parametrize("axis_deg", [0.0, 30.0, 45.0, -60.0, 90.0])
def test_length_width_and_direction_of_a_strip(axis_deg: float) -> None:
    image, bearings, runs = strip_image(30.0, 5.0, np.radians(axis_deg))
    found = measured(image, runs, bearings)
    assert found.half_length_m == pytest.approx(5.0, abs=0.45)
    assert found.half_width_m < 0.75
    off = (np.degrees(found.axis_rad) - axis_deg + 90.0) % 180.0 - 90.0
    assert abs(off) < 4.0


def measured(image: Floats32, runs: list[tuple[int, int, int, int]], bearings: Floats) -> Detection:
    fan = Fan(bearings, np.full(len(bearings), 0.02), image.shape[1], 10.0, 0.1)
    recorded = Recorded((10.0 * image).astype(np.uint16), np.arange(image.shape[1]), 1)
    echoes = measure_echoes(image, Regions(np.array(runs, RUN), 1, 2.0), recorded, fan)
    return Detection(*echoes[0].tolist())


@pytest.mark.parametrize(("beams", "cut"), [((0, 1), True), ((1, 2), False), ((3, 4), True), ((2, 3), False)])
def test_an_echo_in_the_first_or_last_beam_is_cut_off_and_its_place_unsure(beams: tuple[int, int], cut: bool) -> None:
    image = np.ones((5, 50), np.float32)
    for beam in beams:
        image[beam, 20:24] = [4.0, 8.0, 8.0, 4.0]
    echo = measured(image, [(beam, 20, 24, 1) for beam in beams], np.linspace(-0.04, 0.04, 5))
    assert echo.cut is cut
    assert (echo.sigma_bearing_rad * echo.range_m > 4.0) is cut
    assert (echo.sigma_radius_m > 4.0) is cut


@pytest.mark.parametrize(("first", "cut"), [(0, True), (20, False), (46, True)])
def test_an_echo_at_the_nearest_or_farthest_range_is_cut_off_in_range_alone(first: int, cut: bool) -> None:
    image = np.ones((5, 50), np.float32)
    for beam in (1, 2):
        image[beam, first : first + 4] = [4.0, 8.0, 8.0, 4.0]
    echo = measured(image, [(beam, first, first + 4, 1) for beam in (1, 2)], np.linspace(-0.04, 0.04, 5))
    assert echo.cut is cut
    assert (echo.sigma_range_m > 1.4) is cut
    assert (echo.sigma_radius_m > 4.0) is cut
    assert echo.sigma_near_m < 1.0
    assert echo.sigma_bearing_rad * echo.range_m < 1.0


def test_levels_extents_and_raw_peak() -> None:
    image = np.ones((5, 50), np.float32)
    image[1, 20:24] = [4.0, 8.0, 8.0, 4.0]
    image[2, 21:23] = [6.0, 20.0]
    echo = measured(image, [(1, 20, 24, 1), (2, 21, 23, 1)], np.linspace(-0.04, 0.04, 5))
    assert echo.cells == 6
    assert echo.peak == pytest.approx(10.0)
    assert echo.mean == pytest.approx(50.0 / 6.0 / 2.0)
    assert echo.snr_db == pytest.approx(20.0)
    assert echo.range_extent_m == pytest.approx(0.4)
    assert echo.bearing_extent_rad == pytest.approx(0.04)
    assert echo.amplitude == 200.0


def test_lone_cell_and_lone_beam_have_a_finite_circle() -> None:
    image = np.ones((1, 50), np.float32)
    image[0, 30] = 9.0
    echo = measured(image, [(0, 30, 31, 1)], np.array([0.3]))
    assert echo.bearing_rad == pytest.approx(0.3)
    assert echo.range_m == pytest.approx(13.0, abs=0.1)
    assert 0.05 <= echo.radius_m < 0.2
    assert min(echo.sigma_range_m, echo.sigma_bearing_rad, echo.sigma_radius_m) > 0.0


def test_an_echo_has_the_fields_of_the_message_in_its_order() -> None:
    assert ECHO.names is not None
    of_images, of_range_images = (
        Detection.__struct_fields__[: len(ECHO.names)],
        Detection.__struct_fields__[len(ECHO.names) :],
    )
    assert of_images == ECHO.names
    assert of_range_images == ("elevation_extent_rad", "sigma_elevation_rad")
