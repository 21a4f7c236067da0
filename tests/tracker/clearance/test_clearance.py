"""What is told to be empty was looked at: closed forms for one ping and after, and brute force over random pings."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ods.base.arrays import Floats, Mask
from ods.base.clock import NS
from ods.base.frames.geometry import body_to_polar, global_to_body, quat_from_euler, rotation_matrix
from ods.messages import Clearance, Detection, Detections, Obstacle, ObstacleList, PoseAt, Sector, UnseenPart
from ods.tracker.clearance.clearance import ClearanceKeeper
from ods.tracker.clearance.fan_mask import BEARINGS, RANGES, FanMask
from ods.tracker.clearance.free_grid import REACH, ROOM, SIDE, Layer, cells_from_others
from ods.tracker.clearance.sectors import BLUR, OccupiedSectors, _bins, clear_water, nearest_edge
from ods.tracker.settings import ClearanceSettings

N = 72
SETTINGS = ClearanceSettings(sectors=N, half_height_m=0.3, fastest_m_s=2.0, fastest_vertical_m_s=0.5)
RANGE_M = 80.0
CELL_M = ROOM * RANGE_M / REACH
SECTOR = Sector(1.0, RANGE_M, -math.radians(60.0), math.radians(60.0), math.radians(10.0))
SLACK_M = 5.0 * CELL_M
"""Within so much of a border the cells cannot tell, by their size."""
START_NS = 1000 * NS
PERIOD_S = 0.15
ROCK = Obstacle(
    id=7, state="active", position_ned=(30.0, 0.0, 5.0), velocity_ned=(0.0, 0.0, 0.0), radius_m=1.0,
    sigma_position=(0.3, 0.3, 3.0), sigma_velocity=(0.0, 0.0, 0.0), sigma_radius=0.4, first_seen_utc_ns=0,
    last_seen_utc_ns=0, times_seen=9, existence=1.0,
)  # fmt: skip


class Stand(NamedTuple):
    """Where the vehicle is, and its head."""

    north: float = 0.0
    east: float = 0.0
    down: float = 5.0
    yaw: float = 0.0
    pitch: float = 0.0

    @property
    def pose(self) -> PoseAt:
        w, x, y, z = quat_from_euler(0.0, self.pitch, self.yaw).tolist()
        return PoseAt((self.north, self.east, self.down), (w, x, y, z), (0.0,) * 3, (0.0,) * 3, (0.0,) * 3)


HERE = Stand()


def echo(range_m: float, bearing: float, width: float = 0.06) -> Detection:
    """Return a sharp echo of a body of 1 m whose near edge is at `range_m`."""
    return Detection(
        range_m=range_m + 0.5, bearing_rad=bearing, radius_m=0.5, peak=5.0, mean=3.0, snr_db=14.0, cells=9,
        range_extent_m=1.0, bearing_extent_rad=width, sigma_range_m=0.1, sigma_bearing_rad=0.01, sigma_radius_m=0.2,
        near_m=range_m + 0.2, sigma_near_m=0.1,
    )  # fmt: skip


class Bench:
    """A keeper, and the pings that it is given, one every PERIOD_S."""

    def __init__(self) -> None:
        self.keeper = ClearanceKeeper(SETTINGS)
        self.number = -1

    def ping(
        self,
        stand: Stand,
        *,
        sector: Sector = SECTOR,
        processed: Sequence[tuple[float, float]] = (),
        unseen: Sequence[UnseenPart] = (),
        echoes: Sequence[Detection] = (),
        obstacles: Sequence[Obstacle] = (),
        usable: bool = True,
        valid: bool = True,
        left_out: int = 0,
    ) -> Clearance:
        self.number += 1
        k, t_ns, pose = self.number, START_NS + round(self.number * PERIOD_S * NS), stand.pose
        told = ObstacleList(
            k, k, t_ns, t_ns + 5, t_ns, valid, [], list(obstacles), pose=pose, head=pose, made_ns=t_ns, made_utc_ns=1,
            left_out=left_out,
        )  # fmt: skip
        shown = Detections(
            k, k, t_ns, t_ns, t_ns, 1500.0, sector, list(echoes), usable,
            processed_ranges_m=list(processed), unseen=list(unseen),
        )  # fmt: skip
        return self.keeper.after(told, shown)

    def blind(self, stand: Stand, seconds: float) -> Clearance:
        """Let pings pass that show nothing."""
        for _ in range(round(seconds / PERIOD_S)):
            made = self.ping(stand, usable=False)
        return made


def seen(stand: Stand = HERE, **what: Any) -> Clearance:
    """Return what is known after two pings: by one alone nobody knows how the head turns."""
    bench = Bench()
    bench.ping(stand, **what)
    return bench.ping(stand, **what)


def of(made: Clearance, azimuth_deg: float) -> tuple[float, float, float | None]:
    """Return from, to and nearest of the sector with an azimuth."""
    k = math.floor(azimuth_deg / (360.0 / N)) % N
    return made.clear_from_m[k], made.clear_to_m[k], made.nearest_m[k]


def test_in_the_fan_it_is_empty_to_the_sonars_range_and_nothing_is_known_elsewhere() -> None:
    made = seen()
    covered_from_m = SETTINGS.half_height_m / math.sin(SECTOR.half_vertical_rad)
    for azimuth in (-48, -30, 2, 48):
        from_m, to_m, nearest = of(made, azimuth)
        assert covered_from_m <= from_m <= covered_from_m + (SLACK_M if abs(azimuth) < 40 else 4.0 * SLACK_M)
        assert RANGE_M - SLACK_M <= to_m <= RANGE_M
        assert nearest is None
    for azimuth in (62, 90, 180, 270, 298):
        assert of(made, azimuth) == (0.0, 0.0, None)
    assert (made.seq, made.valid, made.pose, made.utc_ns) == (1, True, Stand().pose, made.t_ns + 5)


def test_it_goes_with_the_heading_and_the_place() -> None:
    made = seen(Stand(north=1e4, east=-2e4, yaw=math.radians(200.0)))
    assert of(made, 200.0)[1] > RANGE_M - SLACK_M
    assert of(made, 20.0)[1] == 0.0


def test_it_ends_at_an_echo_and_behind_it_nothing_is_known() -> None:
    made = seen(echoes=[echo(40.0, math.radians(12.0))])
    from_m, to_m, nearest = of(made, 12.0)
    assert nearest == pytest.approx(40.0)
    assert 40.0 - SLACK_M <= to_m <= 40.0
    assert from_m < to_m
    assert of(made, -20.0)[1] > RANGE_M - SLACK_M


def test_an_echo_ends_what_was_held_to_be_empty() -> None:
    bench = Bench()
    for _ in range(3):
        bench.ping(Stand())
    made = bench.ping(Stand(), echoes=[echo(40.0, math.radians(12.0))])
    assert 40.0 - SLACK_M <= of(made, 12.0)[1] <= 40.0
    later = bench.ping(Stand(), usable=False)
    assert of(later, 12.0)[1] <= 40.0
    again = bench.ping(Stand())  # it was none
    assert of(again, 12.0)[1] > RANGE_M - SLACK_M


def test_it_ends_two_standard_deviations_before_an_obstacle() -> None:
    made = seen(obstacles=[ROCK, msgspec.structs.replace(ROCK, position_ned=(-20.0, 0.0, 5.0), state="terminated")])
    from_m, to_m, nearest = of(made, 0.0)
    assert nearest == pytest.approx(29.0)
    assert from_m < to_m
    assert to_m == pytest.approx(29.0 - 2.0 * 0.5)
    assert of(made, 180.0)[2] is None
    inside = seen(Stand(north=30.5), obstacles=[ROCK])
    assert set(inside.nearest_m) == {0.0}
    assert set(inside.clear_to_m) == {0.0}


def test_beyond_the_farthest_of_those_that_had_room_in_the_list_nothing_is_known() -> None:
    made = seen(obstacles=[ROCK], left_out=3)
    assert max(made.clear_to_m) <= 29.0


def test_what_was_not_processed_or_not_seen_is_not_known() -> None:
    rings = seen(processed=[(1.0, 30.0), (50.0, 80.0)])
    assert 30.0 - SLACK_M <= of(rings, 2.0)[1] <= 30.0
    far = seen(processed=[(50.0, 80.0)])
    assert 50.0 <= of(far, 2.0)[0] <= 50.0 + SLACK_M
    part = UnseenPart(math.radians(20.0), math.radians(30.0), 0.0, RANGE_M, "no data")
    dark = seen(unseen=[part])
    assert of(dark, 22.0)[:2] == of(dark, 27.0)[:2] == (0.0, 0.0)
    assert of(dark, 2.0)[1] > RANGE_M - SLACK_M


def test_a_part_of_no_borders_may_be_anywhere() -> None:
    made = seen(unseen=[UnseenPart(math.nan, 0.1, 0.0, 50.0, "no data")])
    assert min(of(made, azimuth)[0] for azimuth in (-30.0, 2.0, 30.0)) >= 50.0
    made = seen(unseen=[UnseenPart(-0.1, 0.1, 0.0, math.nan, "no data")])
    assert of(made, 2.0)[:2] == (0.0, 0.0)


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", ["range_m", "bearing_rad", "radius_m", "near_m", "sigma_near_m", "elevation_rad"])
def test_no_number_that_is_none_comes_out(field: str, wrong: float) -> None:
    bad = msgspec.structs.replace(echo(40.0, 0.0), **{field: wrong})
    made = seen(echoes=[bad])
    numbers = [*made.clear_from_m, *made.clear_to_m, *(each for each in made.nearest_m if each is not None)]
    assert np.all(np.isfinite(numbers))
    assert min(numbers) >= 0.0
    msgspec.convert(msgspec.to_builtins(made), Clearance)


@pytest.mark.parametrize("borders", [(0.0, 0.0, 0.1, -0.1), (5.0, 2.0, -0.1, 0.1), (0.0, math.nan, -0.1, 0.1)])
def test_a_sector_of_no_sense_shows_nothing(borders: tuple[float, float, float, float]) -> None:
    assert max(seen(sector=Sector(*borders, 0.1)).clear_to_m) == 0.0


def test_a_list_that_is_not_valid_knows_of_nothing_nor_does_the_next_one() -> None:
    bench = Bench()
    for _ in range(3):
        bench.ping(Stand())
    made = bench.ping(Stand(), valid=False, obstacles=[ROCK])
    assert (made.valid, max(made.clear_to_m)) == (False, 0.0)
    assert of(made, 0.0)[2] == pytest.approx(29.0)
    assert max(bench.ping(Stand(), usable=False).clear_to_m) == 0.0


def test_without_a_ping_nothing_is_known() -> None:
    told = ObstacleList(0, -1, START_NS, START_NS, 0, False, ["no ping"], [ROCK], pose=None)
    made = ClearanceKeeper(SETTINGS).after(told, None)
    assert (max(made.clear_to_m), set(made.nearest_m), made.pose) == (0.0, {None}, None)


def test_what_is_not_looked_at_any_more_shrinks_as_fast_as_anything_could_come_in() -> None:
    """From the far border it is known to R - v t; the cells' measure may be too careful by sqrt(2)."""
    bench = Bench()
    bench.ping(Stand())
    bench.ping(Stand())
    for k in range(1, 5):
        made = bench.blind(Stand(), 1.5)
        way_m = SETTINGS.fastest_m_s * 1.5 * k
        assert RANGE_M - math.sqrt(2.0) * way_m - SLACK_M <= of(made, 2.0)[1] <= RANGE_M - way_m
    assert max(bench.blind(Stand(), 45.0).clear_to_m) == 0.0


def test_cells_are_so_many_steps_from_the_nearest_that_is_not_in_the_mask() -> None:
    rng = np.random.default_rng(4)
    for shape in ((1, 1), (1, 7), (9, 13), (30, 20)):
        for share in (0.7, 0.97, 1.0):
            mask = rng.random(shape) < share
            others = np.argwhere(~np.pad(mask, 1)) - 1
            steps = np.abs(np.indices(shape)[:, :, :, None] - others.T[:, None, None, :]).sum(axis=0).min(axis=2)
            np.testing.assert_array_equal(cells_from_others(mask), steps)


def test_what_was_looked_at_is_held_while_the_vehicle_turns_away() -> None:
    bench = Bench()
    for k in range(20):
        made = bench.ping(Stand(yaw=math.radians(2.0 * k)))
    assert of(made, 38.0)[1] > RANGE_M - 2.0 * SLACK_M
    assert of(made, -40.0)[1] > 0.0  # out of the fan by 18 deg since 1.3 s at most
    assert of(made, -75.0) == (0.0, 0.0, None)


def test_the_layer_goes_with_the_vehicle_up_and_down() -> None:
    """At 30 m the fan reaches 5.2 m up; 1 m up takes of what is held the time in which something sinks 1 m."""
    bench = Bench()
    bench.ping(Stand())
    bench.ping(Stand())
    up = bench.ping(Stand(down=3.5), usable=False)
    from_m, to_m, _ = of(up, 2.0)
    covered_from_m = (1.5 + SETTINGS.half_height_m) / math.sin(SECTOR.half_vertical_rad)
    assert covered_from_m <= from_m <= covered_from_m + SLACK_M
    assert to_m > from_m
    assert max(bench.ping(Stand(down=-20.0), usable=False).clear_to_m) == 0.0


def test_a_fan_that_looks_down_covers_the_vehicles_depth_only_near_by() -> None:
    made = seen(Stand(pitch=-math.radians(15.0)))
    assert max(made.clear_to_m) == 0.0
    made = seen(Stand(pitch=-math.radians(5.0)))
    assert of(made, 2.0)[1] > RANGE_M - SLACK_M


def test_another_range_of_the_sonar_begins_anew_and_slight_changes_do_not() -> None:
    bench = Bench()
    bench.ping(Stand())
    bench.ping(Stand())
    held = bench.ping(Stand(), sector=msgspec.structs.replace(SECTOR, range_max_m=80.5), usable=False)
    assert of(held, 2.0)[1] > RANGE_M - 2.0 * SLACK_M
    anew = bench.ping(Stand(), sector=msgspec.structs.replace(SECTOR, range_max_m=20.0), usable=False)
    assert max(anew.clear_to_m) == 0.0


class Look(NamedTuple):
    """A ping, for brute force."""

    t_s: float
    stand: Stand
    unseen: UnseenPart | None
    echo: Detection | None

    def shows(self, points: Floats, down: float) -> Mask:
        """Tell (k,) which places (k, 2) north and east, at a depth, it showed to be empty."""
        there = np.column_stack([points, np.full(len(points), down)])
        pose = self.stand.pose
        range_m, bearing, elevation = body_to_polar(global_to_body(there, pose.position_ned, pose.attitude))
        inside = (range_m >= SECTOR.range_min_m) & (range_m <= SECTOR.range_max_m)
        inside &= (np.abs(bearing) <= SECTOR.bearing_max_rad) & (np.abs(elevation) <= SECTOR.half_vertical_rad)
        if self.unseen is not None:
            dark = (bearing > self.unseen.bearing_min_rad) & (bearing < self.unseen.bearing_max_rad)
            inside &= ~(dark & (range_m > self.unseen.range_min_m) & (range_m < self.unseen.range_max_m))
        if self.echo is not None:
            inside &= ~((np.abs(bearing - self.echo.bearing_rad) < 0.03) & (range_m > self.echo.near_m))
        return np.asarray(inside)


angles = st.floats(-0.9, 0.9)
ranges = st.floats(5.0, 75.0)
looks = st.lists(
    st.tuples(
        st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-0.15, 0.15), st.floats(-0.5, 0.5),
        st.none() | st.tuples(angles, ranges), st.none() | st.tuples(angles, ranges), st.booleans(),
    ),
    min_size=2, max_size=8,
)  # fmt: skip


@settings(max_examples=12, deadline=None)
@given(looks, st.floats(0.0, 4.0))
def test_whatever_is_told_to_be_empty_was_seen_so_and_nothing_could_have_come_there_since(
    moves: list[tuple[float, float, float, float, tuple[float, float] | None, tuple[float, float] | None, bool]],
    later_s: float,
) -> None:
    bench, stand, done = Bench(), Stand(), list[Look]()
    for north, east, yaw, down, dark, received, usable in moves:
        stand = Stand(stand.north + north, stand.east + east, stand.down + 0.2 * down, stand.yaw + yaw)
        part = None if dark is None else UnseenPart(dark[0], dark[0] + 0.2, dark[1], dark[1] + 20.0, "saturated")
        found = None if received is None else echo(received[1], received[0])
        t_s = (bench.number + 1) * PERIOD_S
        made = bench.ping(stand, unseen=[part] if part else [], echoes=[found] if found else [], usable=usable)
        if usable:
            done.append(Look(t_s, stand, part, found))
    if later_s > PERIOD_S:
        made = bench.blind(stand, later_s)
    now_s = bench.number * PERIOD_S
    rng = np.random.default_rng(3)
    around = np.column_stack([np.cos(np.arange(8) * math.pi / 4), np.sin(np.arange(8) * math.pi / 4)])
    for k in np.flatnonzero(np.array(made.clear_to_m) > 0.0):
        azimuth = (k + rng.uniform(0.0, 1.0, 12)) * 2.0 * math.pi / N
        away = made.clear_from_m[k] + rng.uniform(0.0, 1.0, 12) * (made.clear_to_m[k] - made.clear_from_m[k])
        points = np.column_stack([np.cos(azimuth), np.sin(azimuth)]) * away[:, None] + [stand.north, stand.east]
        vouched = np.zeros(12, bool)
        for look in done:
            way_m = SETTINGS.fastest_m_s * (now_s - look.t_s)
            all_of_it = np.ones(12, bool)
            for share in (0.5, 1.0):
                for step in around:
                    all_of_it &= look.shows(points + share * way_m * step, stand.down)
            vouched |= all_of_it
        assert vouched.all(), (k, points[~vouched])


def test_what_a_ping_showed_of_the_layer_is_that_of_each_cells_middle() -> None:
    rng = np.random.default_rng(5)
    mask = FanMask(SECTOR, rng.random((BEARINGS, RANGES)) < 0.6, rng.random((BEARINGS, RANGES)) < 0.1)
    layer = Layer((40, 55), rotation_matrix(quat_from_euler(0.1, -0.2, 2.0)), -12.0, -20.0, 1.5, 0.9)
    empty, received, room = layer.in_fan(mask, 0.3)
    forward, starboard, down = layer.in_head()
    away = np.sqrt(forward**2 + starboard**2 + down**2)
    step_rad = (SECTOR.bearing_max_rad - SECTOR.bearing_min_rad) / BEARINGS
    step_m = (SECTOR.range_max_m - SECTOR.range_min_m) / RANGES
    column = np.floor((np.arctan2(starboard, forward) - SECTOR.bearing_min_rad) / step_rad).astype(int)
    row = np.floor((away - SECTOR.range_min_m) / step_m).astype(int)
    inside = (column >= 0) & (column < BEARINGS) & (row >= 0) & (row < RANGES)
    at = np.clip(column, 0, BEARINGS - 1), np.clip(row, 0, RANGES - 1)
    assert inside.any()
    assert not inside.all()
    np.testing.assert_array_equal(empty, inside & mask.empty[at])
    np.testing.assert_array_equal(received, inside & mask.received[at])
    np.testing.assert_allclose(room, away * math.sin(SECTOR.half_vertical_rad) - np.abs(down) - 0.3, atol=1e-12)


@given(st.integers(0, 2**32 - 1), st.integers(4, 90))
@settings(deadline=None, max_examples=20)
def test_clear_water_is_the_first_stretch_of_three_rings(seed: int, sectors: int) -> None:
    rng = np.random.default_rng(seed)
    free = rng.random((SIDE, SIDE)) < rng.choice([0.5, 0.9, 0.99, 0.999])
    known = np.ones((sectors, REACH), bool)
    bins = _bins(sectors)
    np.logical_and.at(known.reshape(-1), bins.bin, free.ravel()[bins.cell])
    clear = clear_water(free, 1.0, sectors)
    for sector, rings in enumerate(known):
        starts = [k for k in range(REACH - 2) if rings[k : k + 3].all()]
        first = starts[0] if starts else 0
        last = first + int(np.argmin(np.append(rings[first:], False))) if starts else 0
        from_m, to_m = (first + BLUR if first else 0.0), last - BLUR
        expected = (from_m, to_m) if to_m > from_m else (0.0, 0.0)
        assert (clear.from_m[sector], clear.to_m[sector]) == pytest.approx(expected)


def test_the_nearest_body_of_a_sector_is_the_one_that_reaches_into_it() -> None:
    rng = np.random.default_rng(2)
    azimuth, half, distance, sigma = rng.uniform([[-4.0], [0.0], [0.0], [0.0]], [[4.0], [1.0], [50.0], [9.0]], (4, 20))
    middle = (np.arange(N) + 0.5) * 2.0 * np.pi / N
    off = np.abs((middle[:, None] - azimuth + np.pi) % (2.0 * np.pi) - np.pi)
    away = np.where(off <= half + np.pi / N, np.maximum(distance - 2.0 * sigma, 0.0), np.inf).min(axis=1)
    np.testing.assert_allclose(nearest_edge(OccupiedSectors(azimuth, half, distance, sigma), N, 2.0), away)
    assert np.isinf(nearest_edge(OccupiedSectors(*np.zeros((4, 0))), N)).all()
