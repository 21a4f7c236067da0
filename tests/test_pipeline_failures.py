"""What goes wrong in real images [SSIE]: each failure with truth. 8-bit log counts of speckle of mean intensity 1."""

import numpy as np
import pytest
from numpy.typing import NDArray
from pipeline_pings import body_echo, fan_bearings, make_ping, speckle

from ods.messages import Detection
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings

BEARINGS = fan_bearings(60)
Array = NDArray[np.float64]


def found(intensity: Array, seed: int = 1, chain: Chain | None = None) -> list[Detection]:
    """Detections of the default chain in speckle of this mean intensity."""
    counts = np.rint(40.0 * np.log10(1.0 + 8.0 * speckle(np.random.default_rng(seed), intensity)))
    ping = make_ping(np.minimum(counts, 255.0).astype(np.uint8), scale="log8", scale_factor=40.0)
    return (chain or Chain(PipelineSettings())).process(ping).detections


def body(range_m: float, bearing: float, radius: float = 1.5, snr_db: float = 20.0) -> Array:
    return np.asarray(10.0 ** (snr_db / 10.0) * body_echo("half", radius, range_m, bearing, BEARINGS, 2000))


def hits(detections: list[Detection], range_m: float, bearing: float) -> int:
    return sum(np.hypot(d.range_m - range_m, range_m * (d.bearing_rad - bearing)) < 2.5 for d in detections)


def test_drop_outs_are_no_echoes_and_hide_only_themselves() -> None:
    intensity = 1.0 + body(40.0, 0.1) + body(60.0, -0.2)
    for column in (1560, 1640):  # 78 and 82 m, as in the paper's image
        intensity[:, column : column + 8] = 1e-6
    detections = found(intensity)
    assert hits(detections, 40.0, 0.1) == hits(detections, 60.0, -0.2) == 1
    assert len(detections) == 2


def test_belts_of_the_gain_are_no_echoes() -> None:
    intensity = 1.0 + body(55.0, 0.1) + body(75.0, -0.2) + body(30.0, 0.3)
    intensity[:, 1000:1200] *= 0.3  # a dark belt at 50 to 60 m
    intensity[:, 1400:1600] *= 4.0  # a light one at 70 to 80 m
    detections = found(intensity)
    assert [hits(detections, *place) for place in ((55.0, 0.1), (75.0, -0.2), (30.0, 0.3))] == [1, 1, 1]
    assert len(detections) == 3


def test_bottom_from_18_m_is_no_echo() -> None:
    column = np.arange(2000)
    bias = np.where(column < 360, 1.0, 40.0 * np.exp(-(column - 360) / 400.0) + 1.0)
    detections = found(bias * (1.0 + body(30.0, 0.1)))
    assert hits(detections, 30.0, 0.1) == 1
    assert len(detections) <= 2


def test_weak_specular_objects_are_found_more_often_than_not() -> None:
    """A highlight of a few cells in one beam, 14 dB over the speckle."""
    chain = Chain(PipelineSettings())
    score = 0
    for seed in range(20):
        intensity = np.ones((60, 2000))
        intensity[30, 800:808] += 10.0**1.4
        score += hits(found(intensity, seed, chain), 40.2, float(BEARINGS[30])) > 0
    assert score > 10


def test_nothing_is_found_where_nothing_is() -> None:
    stages = (
        {"use": "equalize.mean_range"},
        {"use": "filter.fir"},
        {"use": "detect.two_level", "levels": "false_alarm", "rate": 1e-9},
    )
    chain = Chain(PipelineSettings(stage=stages))
    assert sum(len(found(np.ones((60, 2000)), seed, chain)) for seed in range(60)) == 0


def test_quay_across_the_whole_sector_is_found() -> None:
    intensity = np.ones((60, 2000))
    for row, bearing in zip(intensity, BEARINGS, strict=True):
        column = round(30.0 / np.cos(bearing) / 0.05)
        row[column : column + 12] += 200.0
    wall = max(found(intensity), key=lambda detection: detection.cells)
    assert wall.bearing_extent_rad > 0.8 * np.pi / 2.0
    ring = np.ones((60, 2000))
    ring[:, 600:612] += 200.0  # at one range everywhere: the worst for an equalizer
    assert max(found(ring), key=lambda detection: detection.cells).bearing_extent_rad > 0.8 * np.pi / 2.0


@pytest.mark.parametrize("bearing", [float(BEARINGS[0]), float(BEARINGS[-1])])
def test_object_at_the_sector_s_edge_is_found_and_its_place_is_uncertain(bearing: float) -> None:
    inside = found(1.0 + body(40.0, 0.1))[0]
    edge = [d for d in found(1.0 + body(40.0, bearing)) if abs(d.range_m - 40.0) < 2.0]
    assert len(edge) == 1
    assert abs(edge[0].bearing_rad - bearing) < 0.05
    assert edge[0].sigma_bearing_rad > 5.0 * inside.sigma_bearing_rad


@pytest.mark.parametrize("range_m", [2.0, 98.0])
def test_objects_at_the_range_ends_are_found(range_m: float) -> None:
    assert hits(found(1.0 + body(range_m, 0.1, 0.8 if range_m < 5.0 else 1.5)), range_m, 0.1) >= 1


def test_two_objects_closer_than_the_beam_are_one_echo_that_holds_both() -> None:
    intensity = 1.0 + body(80.0, 0.100, 0.5) + body(80.0, 0.115, 0.5)  # 1.2 m apart, a beam is 2.1 m wide
    detections = found(intensity)
    assert len(detections) == 1
    assert detections[0].range_m == pytest.approx(80.0, abs=1.0)
    assert detections[0].bearing_rad == pytest.approx(0.1075, abs=0.013)


def test_errors_are_as_large_as_the_standard_deviations_say() -> None:
    """Normalised squared errors of near halves and whole discs of 0.5 to 3 m at 12 to 85 m: 1 a coordinate."""
    rng = np.random.default_rng(3)
    chain = Chain(PipelineSettings())
    squares = []
    for k in range(120):
        radius, range_m, bearing = rng.choice([0.5, 1.0, 2.0, 3.0]), rng.uniform(12.0, 85.0), rng.uniform(-0.5, 0.5)
        shape = ("half", "disc")[k % 2]
        echo = 100.0 * body_echo(shape, float(radius), range_m, bearing, BEARINGS, 2000)
        best = max(found(1.0 + echo, k, chain), key=lambda detection: detection.cells)
        error = (best.range_m - range_m, best.bearing_rad - bearing, best.radius_m - radius)
        sigma = (best.sigma_range_m, best.sigma_bearing_rad, best.sigma_radius_m)
        squares.append(np.square(np.divide(error, sigma)))
    mean = np.mean(squares, axis=0)
    assert mean.sum() == pytest.approx(3.0, abs=1.0)
    assert mean.min() > 0.5
    assert mean.max() < 1.6
