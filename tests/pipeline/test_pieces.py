"""Walls and the like are cut into pieces that stay where they are in the world."""

import math

import numpy as np
import pytest

from ods.base.arrays import Floats, Mask
from ods.base.frames.geometry import body_to_global, polar_to_body
from ods.base.frames.quaternion import from_euler
from ods.messages import Pose
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import RUN, Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.measure.echoes import EchoTable
from ods.pipeline.measure.pieces import LARGEST_M, SIDE_M, measure_pieces

FAN = Fan(np.radians(np.linspace(-44.25, 44.25, 60)), np.full(60, np.radians(1.5)), 600, 10.0, 0.1, 0.05)
MIDDLE_NE = (40.0, 3.0)
STILL = (0.0, 0.0, 0.0)


def head_at(north: float, east: float, yaw_deg: float) -> Pose:
    attitude = from_euler(0.02, -0.03, math.radians(yaw_deg))
    return Pose(0, 0, 0, (north, east, 5.0), attitude, STILL, STILL, STILL)


AHEAD = head_at(0.0, 0.0, 0.0)


def places_ne(head: Pose) -> Floats:
    """Return (beams, columns, 2) north and east of all cells."""
    in_head = polar_to_body(FAN.range_m[None, :], FAN.bearing_rad[:, None], np.array(FAN.elevation_rad))
    return body_to_global(in_head, np.array(head.position_ned), np.array(head.attitude))[..., :2]


def wall(head: Pose, half_m: float, azimuth_deg: float) -> Mask:
    """Return (beams, columns) the cells of a wall 0.8 m thick."""
    away, azimuth = places_ne(head) - MIDDLE_NE, math.radians(azimuth_deg)
    along = away @ np.array([math.cos(azimuth), math.sin(azimuth)])
    across = away @ np.array([-math.sin(azimuth), math.cos(azimuth)])
    return np.asarray((np.abs(along) <= half_m) & (np.abs(across) <= 0.4))


def cut(bodies: list[Mask], head: Pose | None) -> tuple[Regions, EchoTable]:
    """Return the pieces of an image in which these cells shine; every other body is faint."""
    runs = []
    for number, cells in enumerate(bodies, 1):
        steps = np.diff(np.pad(cells, ((0, 0), (1, 1))).astype(np.int8), axis=1)
        runs += [
            (b, i, j, number) for (b, i), (_, j) in zip(np.argwhere(steps > 0), np.argwhere(steps < 0), strict=True)
        ]
    noise = np.random.default_rng(1).exponential(size=FAN.shape)
    level = np.where(np.any(bodies, axis=0), 8.0, 0.0) + noise
    image = np.apply_along_axis(np.convolve, 1, level, np.full(3, 1.0 / 3.0), "same").astype(np.float32)
    recorded = Recorded((10.0 * image).astype(np.uint16), np.arange(FAN.samples), 1)
    faint = np.arange(len(bodies)) % 2 == 1
    return measure_pieces(image, Regions(np.array(runs, RUN), len(bodies), 1.0, faint=faint), recorded, FAN, head)


def centres_ne(echoes: EchoTable, head: Pose) -> Floats:
    """Return (echoes, 2) where their circles are."""
    in_head = polar_to_body(echoes["range_m"], echoes["bearing_rad"], echoes["elevation_rad"])
    return body_to_global(in_head, np.array(head.position_ned), np.array(head.attitude))[:, :2]


@pytest.mark.parametrize("azimuth_deg", [0.0, 30.0, 63.0, 90.0, 135.0])
def test_the_pieces_of_a_wall_cover_it_and_reach_no_farther_than_they_are_large(azimuth_deg: float) -> None:
    cells = wall(AHEAD, 12.0, azimuth_deg)
    _, echoes = cut([cells], AHEAD)
    away = places_ne(AHEAD)[cells][:, None] - centres_ne(echoes, AHEAD)
    assert (np.hypot(away[..., 0], away[..., 1]) - echoes["radius_m"]).min(axis=1).max() < 0.7
    assert len(echoes) > 4
    assert echoes["radius_m"].max() < SIDE_M / math.sqrt(2.0) + 0.5


def test_each_cell_is_of_one_piece_which_lies_in_one_square_of_the_world() -> None:
    head, small = head_at(-5.0, 2.0, 20.0), np.zeros(FAN.shape, np.bool_)
    small[40:42, 100:110] = True
    bodies = [wall(head, 15.0, 70.0), small]
    regions, _ = cut(bodies, head)
    square = np.floor(places_ne(head) / SIDE_M)
    number = np.zeros(FAN.shape, np.int64)
    for beam, first, stop, region in regions.runs.tolist():
        assert not number[beam, first:stop].any()
        number[beam, first:stop] = region
    np.testing.assert_array_equal(number > 0, bodies[0] | bodies[1])
    of_squares = {tuple(each) for each in square[bodies[0]].tolist()}
    assert len(of_squares) == regions.total - 1
    for region in range(1, regions.total):
        assert len({tuple(each) for each in square[number == region].tolist()}) == 1
    assert set(number[small].tolist()) == {regions.total}
    assert regions.faint is not None
    assert regions.faint.tolist() == [False] * (regions.total - 1) + [True]
    order = regions.runs[["region", "beam", "first"]].tolist()
    assert order == sorted(order)


def test_the_pieces_stay_where_they_are_as_the_sonar_moves_and_turns() -> None:
    moved = head_at(6.0, -3.0, 12.0)
    before, after = (centres_ne(cut([wall(head, 1.2 * LARGEST_M, 80.0)], head)[1], head) for head in (AHEAD, moved))
    assert len(before) == len(after)
    away = before[:, None] - after
    assert np.hypot(away[..., 0], away[..., 1]).min(axis=1).max() < 0.7


def test_what_is_small_stays_whole_and_all_does_while_the_head_is_not_known() -> None:
    small, large = wall(AHEAD, 0.8 * LARGEST_M, 80.0), wall(AHEAD, 1.5 * LARGEST_M, 80.0)
    assert len(cut([small], AHEAD)[1]) == 1
    assert len(cut([large], AHEAD)[1]) > 4
    assert len(cut([large], None)[1]) == 1


@pytest.mark.parametrize("head", [AHEAD, None])
def test_what_is_larger_than_a_patch_of_bottom_has_no_onset(head: Pose | None) -> None:
    """A long wall that stands aslant to the beams sets in slowly, and is no clutter."""
    for half_m, known in ((0.8 * LARGEST_M, True), (1.2 * LARGEST_M, False)):
        _, echoes = cut([wall(AHEAD, half_m, 80.0)], head)
        assert (echoes["onset"] > 0.0).all() == known
        assert (echoes["onset"] == 0.0).all() != known
