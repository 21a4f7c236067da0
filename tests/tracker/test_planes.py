"""Sonars of several planes: a body in two of them is one echo, and its height is that of its plane."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchmarks.tracker.planes import ELEVATIONS_DEG, found_in, hovering, pings_of, seen_of, tracked
from ods.base.arrays import Floats
from ods.messages import Detection, Detections, Sector
from ods.tracker.measurement.from_detections import received
from ods.tracker.measurement.model import position_measurement
from ods.tracker.measurement.planes import SIDE_LOBE_DB, merge_planes
from ods.tracker.measurement.scan import EchoRows, echo_table_of, echoes_of, vehicle_at

HALF = math.radians(10.0)
UP = math.radians(20.0)


def row(elevation: float = 0.0, strength: float = 20.0, **others: float) -> tuple[float, ...]:
    reported = {"range_m": 40.0, "bearing": 0.1, "radius": 1.0, "sigma_range": 0.2, "sigma_bearing": 0.01}
    echo = {"elevation": elevation, "strength": strength, "sigma_radius": 0.3, "cut": 0.0}
    values = reported | echo | {"half_vertical": 0.0, "onset": 0.0, "front": 0.0} | others
    return tuple(values[name] for name in EchoRows._fields)


def merged(*rows: tuple[float, ...]) -> Floats:
    """Return the (k, 12) echoes that become of rows."""
    return merge_planes(echoes_of(np.array(rows))[0], HALF).table.T


def test_a_body_received_alike_is_between_its_planes() -> None:
    one = row(0.0, 20.1, range_m=39.9)
    found = merged(row(UP, 20.0, range_m=40.2, bearing=0.12, radius=1.5, sigma_radius=0.4), one)
    assert found.shape == (1, len(EchoRows._fields))
    reported = dict(zip(EchoRows._fields, found[0].tolist(), strict=True))
    assert reported["elevation"] == pytest.approx(HALF, abs=0.002)
    assert reported["half_vertical"] == pytest.approx(0.5 * HALF, rel=0.01)
    assert (reported["radius"], reported["sigma_radius"]) == (1.5, 0.4)
    assert [reported[name] for name in ("range_m", "bearing", "sigma_range", "sigma_bearing")] == [39.9, 0.1, 0.2, 0.01]


@given(louder_db=st.floats(-14.9, 14.9))
def test_elevation_and_opening_follow_the_levels(louder_db: float) -> None:
    found = merged(row(UP, 25.0), row(0.0, 25.0 + louder_db))
    lean = math.tanh(louder_db * math.log(10.0) / 40.0)
    assert found[0, 2] == pytest.approx(HALF * (1.0 - lean), abs=1e-9)
    assert found[0, 9] == pytest.approx(HALF * 0.5 * (1.0 + abs(lean)), abs=1e-9)


def test_the_second_loudest_tells_and_side_lobes_do_not() -> None:
    found = merged(row(-UP, 8.0), row(0.0, 25.0), row(UP, 20.0))
    assert len(found) == 1
    assert found[0, 2] == pytest.approx(merged(row(0.0, 25.0), row(UP, 20.0))[0, 2])
    faint = merged(row(0.0, 25.0), row(UP, 25.0 - SIDE_LOBE_DB))
    assert faint[:, [2, 9]].tolist() == [[0.0, HALF]]


@pytest.mark.parametrize(
    "other",
    [
        row(0.0, 15.0),
        row(2.0 * UP, 15.0),
        row(UP, 15.0, range_m=41.0),
        row(UP, 15.0, bearing=0.15),
    ],
    ids=["same plane", "no neighbour", "other range", "other bearing"],
)
def test_echoes_of_different_bodies_stay_apart(other: tuple[float, ...]) -> None:
    rows = np.array([row(), other])
    found = merged(*rows)
    assert np.array_equal(found[:, :9], rows[:, :9])
    assert (found[:, 9] == HALF).all()


def detection(elevation: float, bearing: float) -> Detection:
    return Detection(
        range_m=40.0,
        bearing_rad=bearing,
        radius_m=0.5,
        peak=9.0,
        mean=5.0,
        snr_db=20.0,
        cells=9,
        range_extent_m=1.0,
        bearing_extent_rad=0.1,
        sigma_range_m=0.2,
        sigma_bearing_rad=0.01,
        sigma_radius_m=0.3,
        elevation_rad=elevation,
    )


def test_without_planes_echoes_are_what_they_were() -> None:
    detections = [detection(elevation, bearing) for elevation, bearing in ((0.0, -0.2), (UP, 0.1), (0.0, 0.1))]
    message = Detections(0, 0, 0, 0, 0, 1500.0, Sector(0.0, 100.0, -0.8, 0.8, HALF), detections)
    scan = received(message, hovering(0), lambda _: None, 0).scan
    assert scan.echoes.table.tobytes() == echoes_of(echo_table_of(detections))[0].table.tobytes()
    assert (scan.echoes.rows.half_vertical == 0.0).all()


def test_height_is_that_of_the_plane_and_not_of_the_stack() -> None:
    zeros = np.zeros(3)
    vehicle = vehicle_at(zeros, np.array([1.0, 0.0, 0.0, 0.0]), zeros, zeros)
    assert vehicle is not None
    rows = np.array([row(UP), row(UP, half_vertical=HALF)])
    found = position_measurement(echoes_of(rows)[0], vehicle, 3.0 * HALF)
    assert found.position[2] == pytest.approx(-40.0 * math.sin(UP))
    assert found.half_height == pytest.approx([40.0 * math.sin(3.0 * HALF), 40.0 * math.sin(HALF)])


def test_eight_spheres_before_three_planes_are_eight_tracks_of_known_height() -> None:
    found = found_in(pings_of(ELEVATIONS_DEG[0], 3.0))
    assert found[-1].sector.plane_half_rad == pytest.approx(HALF)
    tracks = tracked(found, by_plane=True)
    seen = list(seen_of(tracks, ELEVATIONS_DEG[0]))
    assert [len(each.nees) for each in seen] == [1] * 8
    assert len(tracks) == 8
    nees = np.concatenate([each.nees for each in seen]).mean(axis=0)
    assert (nees < 2.5).all()
    assert max(each.sigma_height.max() for each in seen) < 1.1 * 40.0 * math.sin(HALF) / math.sqrt(3.0)
