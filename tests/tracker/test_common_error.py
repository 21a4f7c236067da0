"""Objects at rest that all seem to move alike: which error of pose, mounting or sound speed it is, and how large."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.messages import Sector
from ods.tracker.common_error.causes import WRONG_SCALE, WRONG_YAW, Cause, estimate
from ods.tracker.common_error.least_squares import FadingSums, Reduced, fit
from ods.tracker.common_error.monitor import CommonErrors
from ods.tracker.common_error.sightings import COLUMNS, EAST, NORTH, OWN, TURN, WHOLE, YAW, Motion, Sightings
from ods.tracker.existence.lifecycle import ACTIVE
from ods.tracker.map.map_object import MapObject
from ods.tracker.measurement.scan import Scan, Vehicle, echoes_of
from ods.tracker.output.snapshot import Snapshot, snapshot_of_map

PING_S, SIGMA_RANGE, SIGMA_BEARING = 0.15, 0.1, 0.01
SECTOR = Sector(1.0, 120.0, -0.8, 0.8, 0.17)
STEP_S = 6.0
AHEAD = np.array([[40.0, -12.0], [60.0, 20.0], [52.0, -25.0], [80.0, 9.0], [95.0, -6.0]])


class Wrong(NamedTuple):
    """What is wrong with what the tracker receives."""

    yaw: float = 0.0
    turn: float = 0.0
    scale: float = 0.0
    latency: float = 0.0
    drift: tuple[float, float] = (0.0, 0.0)
    step: float = 0.0
    """Of the heading, rad, after STEP_S."""
    mirrored: bool = False


class World(NamedTuple):
    """Bodies, (n, 2), with velocities, before a vehicle that weaves, and goes where it heads."""

    bodies: Floats = AHEAD
    velocity: Floats = np.zeros((1, 2))
    speed: float = 1.2
    weave: float = math.radians(20.0)

    def heading(self, t_s: float) -> float:
        """Return the vehicle's."""
        return self.weave * math.sin(t_s / 3.0)

    def course(self, t_s: float) -> Floats:
        """Return the vehicle's velocity, (2,)."""
        return self.speed * np.array([math.cos(self.heading(t_s)), math.sin(self.heading(t_s))])

    def place(self, t_s: float) -> Floats:
        """Return the vehicle's, (2,), from the origin at 10 s on, by Simpson's rule."""
        times = np.linspace(10.0, t_s, 101)
        weights = np.array([1.0, *[4.0, 2.0] * 49, 4.0, 1.0]) * (t_s - 10.0) / 300.0
        headings = self.weave * np.sin(times / 3.0)
        return np.asarray(self.speed * np.array([np.cos(headings), np.sin(headings)]) @ weights)

    def pings(self, wrong: Wrong, seconds: float, seed: int = 1) -> "list[tuple[Snapshot, Scan, Motion]]":
        """Return what each ping shows by the pose as it is reported."""
        rng, shown = np.random.default_rng(seed), []
        for k in range(int(seconds / PING_S)):
            t_s = 10.0 + k * PING_S
            away = self.bodies + self.velocity * (t_s - 10.0) - self.place(t_s)
            range_m = np.hypot(*away.T) + rng.normal(0.0, SIGMA_RANGE, len(away))
            bearing = np.arctan2(away[:, 1], away[:, 0]) - self.heading(t_s)
            bearing += rng.normal(0.0, SIGMA_BEARING, len(away))
            bearing *= -1.0 if wrong.mirrored else 1.0
            shown.append(self._reported(t_s, range_m * (1.0 + wrong.scale), bearing, wrong))
        return shown

    def _reported(self, t_s: float, range_m: Floats, bearing: Floats, wrong: Wrong) -> tuple[Snapshot, Scan, Motion]:
        posed_s = t_s + wrong.latency
        heading = self.heading(posed_s) + wrong.yaw + wrong.turn * (t_s - 10.0)
        heading += wrong.step if t_s - 10.0 > STEP_S else 0.0
        place = self.place(posed_s) + np.array(wrong.drift) * (t_s - 10.0)
        turned = np.array([[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]])
        rotation = np.eye(3)
        rotation[:2, :2] = turned
        vehicle = Vehicle(np.append(place, 5.0), rotation, np.full(3, 0.1), np.full(3, 0.005))
        sigma = SIGMA_RANGE * (1.0 + wrong.scale)
        rows = [(r, b, 0.0, 0.5, sigma, SIGMA_BEARING, 0.1) for r, b in zip(range_m, bearing, strict=True)]
        scan = Scan(round(t_s * NS), 0, vehicle, SECTOR, echoes_of(np.array(rows))[0])
        ahead = np.array([range_m * np.cos(bearing), range_m * np.sin(bearing)])
        yaw_rate = self.weave / 3.0 * math.cos(posed_s / 3.0) + wrong.turn
        return objects_at(place[:, None] + turned @ ahead), scan, Motion(self.course(posed_s), yaw_rate)


def objects_at(places: Floats) -> Snapshot:
    """Return active objects at (2, n) places."""
    objects = [MapObject(k, (*place, 5.0), (0.2,) * 3, 1.0, 0.1, 1.0, 9, 0, 0, 0) for k, place in enumerate(places.T)]
    snapshot = snapshot_of_map(objects)
    snapshot.state[:] = ACTIVE
    return snapshot


def after(world: World, wrong: Wrong, seconds: float = 30.0, seed: int = 1) -> CommonErrors:
    errors = CommonErrors()
    for ping in world.pings(wrong, seconds, seed):
        errors.look(*ping)
    return errors


def number(text: str) -> tuple[float, float]:
    """Return the first value and its standard error."""
    value, sigma = re.findall(r"(-?[\d.]+) \+- ([\d.]+)", text)[0]
    return float(value), float(sigma)


CAUSES: list[tuple[Wrong, str, float]] = [
    (Wrong(yaw=math.radians(2.0)), "sonar.mounting.yaw_deg, or the heading, is {} deg too large", 2.0),
    (Wrong(yaw=math.radians(-1.5)), "sonar.mounting.yaw_deg, or the heading, is {} deg too small", 1.5),
    (Wrong(turn=math.radians(2.0)), "static objects seem to turn by {} deg/s about the vehicle", 2.0),
    (Wrong(turn=math.radians(-0.2)), "static objects seem to turn by {} deg/s about the vehicle", -0.2),
    (Wrong(scale=0.02), "ranges are {} % too long: is the sound speed right?", 2.0),
    (Wrong(scale=-0.03), "ranges are {} % too short: is the sound speed right?", 3.0),
    (Wrong(latency=0.1), "poses are stamped {} ms too early, by the pings' clock", 100.0),
    (Wrong(latency=-0.1), "poses are stamped {} ms too late, by the pings' clock", 100.0),
    (Wrong(drift=(0.3, -0.2)), "static objects seem to move by {} m/s: does the INS's position drift?", 0.36),
]


@pytest.mark.parametrize(("wrong", "words", "size"), CAUSES)
def test_each_error_is_named_with_its_size(wrong: Wrong, words: str, size: float) -> None:
    problem = after(World(), wrong).problem()
    before, behind = words.split("{}")
    assert before in problem
    assert behind in problem
    value, sigma = number(problem)
    assert abs(value - size) <= 4.0 * sigma + 0.05 * abs(size)


def test_a_standard_error_is_as_large_as_the_error() -> None:
    squares = []
    for seed in range(12):
        bodies = np.column_stack([seed % 5 + np.linspace(35.0, 95.0, 6), 30.0 * np.sin(np.arange(6) + seed)])
        finding = after(World(bodies), Wrong(yaw=math.radians(2.0)), seed=seed)._findings[0]
        squares.append(((finding.value - math.radians(2.0)) / finding.sigma) ** 2)
    assert 0.2 < np.mean(squares) < 2.5


def test_without_an_error_nothing_is_said() -> None:
    for seed in range(10):
        assert not after(World(), Wrong(), 20.0, seed).problem()


def test_one_mover_among_five_does_not_hide_a_turn() -> None:
    movers = np.zeros((5, 2))
    movers[2] = 0.8, -0.6
    problem = after(World(velocity=movers), Wrong(turn=math.radians(2.0)), 6.0).problem()
    assert "turn by 2." in problem or "turn by 1.9" in problem


def test_three_movers_do_not_turn_about_us_by_chance() -> None:
    rng, said = np.random.default_rng(4), 0
    for seed in range(25):
        bodies = np.column_stack([rng.uniform(40.0, 90.0, 3), rng.uniform(-40.0, 40.0, 3)])
        world = World(bodies, rng.uniform(-1.5, 1.5, (3, 2)))
        errors = CommonErrors()
        for ping in world.pings(Wrong(), 12.0, seed):
            errors.look(*ping)
            said += bool(errors.reasons())
    assert said <= 0.01 * 25 * 12.0 / PING_S


@pytest.mark.parametrize(
    ("wrong", "not_valid"),
    [
        (Wrong(turn=math.radians(2.0)), True), (Wrong(turn=math.radians(0.3)), False), (Wrong(drift=(0.5, 0.5)), False),
        (Wrong(yaw=math.radians(2.0)), False), (Wrong(yaw=math.radians(8.0)), True), (Wrong(scale=0.08), True),
    ],
)  # fmt: skip
def test_a_list_is_valid_up_to_a_limit_and_movers_alike_may_be_a_convoy(wrong: Wrong, not_valid: bool) -> None:
    errors = after(World(), wrong)
    assert errors.problem()
    assert bool(errors.reasons()) == not_valid


@pytest.mark.parametrize(("drift", "not_valid"), [((0.6, 0.6), True), ((0.2, 0.2), False)])
def test_movers_alike_are_no_convoy_where_the_poses_are_doubtful(drift: tuple[float, float], not_valid: bool) -> None:
    errors = after(World(), Wrong(drift=drift))
    assert not errors.reasons()
    assert bool(errors.reasons(convoy=False)) == not_valid


@pytest.mark.parametrize("wrong", [Wrong(yaw=math.radians(90.0)), Wrong(scale=2.28)])
def test_what_all_moves_faster_than_the_vehicle_is_no_convoy(wrong: Wrong) -> None:
    """The heading is far off, or ranges are in feet."""
    assert "times as fast as the vehicle: is the heading wrong" in after(World(weave=0.0), wrong, 15.0).reasons()[0]


@pytest.mark.parametrize(
    "wrong", [Wrong(yaw=math.radians(2.0)), Wrong(scale=0.03), Wrong(latency=0.1), Wrong(turn=math.radians(0.1))]
)
def test_what_is_wrong_by_a_known_amount_is_in_the_covariance(wrong: Wrong) -> None:
    world = World()
    *_, (snapshot, _, _) = world.pings(wrong, 30.0)
    wider = after(world, wrong).widened(snapshot)
    grown = wider.sigma_position[:2] ** 2 - snapshot.sigma_position[:2] ** 2
    off = snapshot.position[:2] - world.bodies.T
    large = np.abs(off) > 0.5
    assert large.any()
    np.testing.assert_allclose(np.sqrt(grown[large]), np.abs(off[large]), rtol=0.4, atol=0.25)
    products = wider.covariance_ne - snapshot.covariance_ne
    np.testing.assert_allclose(products**2, grown[0] * grown[1], rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(after(world, Wrong()).widened(snapshot).sigma_position, snapshot.sigma_position)


def seconds_until(world: World, wrong: Wrong, words: str, seconds: float, seed: int) -> tuple[float, str]:
    """Return after which time the list is first not valid for it, s, and the reason."""
    errors = CommonErrors()
    for k, ping in enumerate(world.pings(wrong, seconds, seed)):
        errors.look(*ping)
        for reason in errors.reasons():
            if words in reason:
                return k * PING_S, reason
    raise AssertionError(errors.problem())


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("world", [World(), World(weave=0.0), World(weave=0.0, speed=0.0)])
def test_a_step_of_the_heading_is_said_within_a_second(world: World, seed: int) -> None:
    words = "bearings, or the heading, have changed by "
    at_s, reason = seconds_until(world, Wrong(step=math.radians(6.0)), words, STEP_S + 2.0, seed)
    assert STEP_S < at_s <= STEP_S + 1.0
    assert abs(float(reason.split(words)[1].split()[0]) - 6.0) < 1.5


@pytest.mark.parametrize("seed", range(3))
def test_mirrored_images_are_reported_when_the_vehicle_turns(seed: int) -> None:
    at_s, _ = seconds_until(World(), Wrong(mirrored=True), "have changed by", 10.0, seed)
    assert at_s < 4.0


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("world", "degrees"), [(World(weave=0.0), 15.0), (World(), -15.0), (World(), 30.0)])
def test_beams_that_are_shifted_are_named_with_the_right_size_within_six_seconds(
    world: World, degrees: float, seed: int
) -> None:
    wrong = Wrong(yaw=math.radians(degrees))
    _, reason = seconds_until(world, wrong, "sonar.mounting.yaw_deg, or the heading", 6.0, seed)
    value, sigma = number(reason)
    assert abs(value - abs(degrees)) < 3.0 * sigma
    assert ("large" in reason) == (degrees > 0.0)


@pytest.mark.parametrize(
    ("cause", "wrong", "true"),
    [(WRONG_YAW, Wrong(yaw=math.radians(3.0)), math.radians(3.0)), (WRONG_SCALE, Wrong(scale=0.03), 0.03)],
)
def test_first_estimates_are_as_far_off_as_they_claim(cause: Cause, wrong: Wrong, true: float) -> None:
    """The noise of echoes, whose places the design was made of, made them too small by more than two sigmas."""
    squares = []
    for seed in range(8):
        errors = CommonErrors()
        for k, ping in enumerate(World().pings(wrong, 10.0, seed)):
            errors.look(*ping)
            if k % 10 == 9 and (found := estimate(errors._slow.reduced(), cause)):
                squares.append(((found.value - true) / found.sigma) ** 2)
    assert len(squares) > 40
    assert np.mean(squares) < 1.5


def test_a_school_that_moves_alike_past_a_hovering_vehicle_leaves_the_list_valid() -> None:
    for seed, velocity in enumerate(((0.9, 0.3), (-0.2, 0.8), (0.0, -1.2))):
        errors = CommonErrors()
        for ping in World(velocity=np.array([velocity]), speed=0.0, weave=0.0).pings(Wrong(), 15.0, seed):
            errors.look(*ping)
            assert not errors.reasons()
        assert "static objects seem to move" in errors.problem()


@pytest.mark.parametrize("share", [-0.5, -0.1, 0.3])
def test_an_error_of_the_ranges_by_a_tenth_or_more_is_reported_for_good(share: float) -> None:
    errors = CommonErrors()
    for k, ping in enumerate(World().pings(Wrong(scale=share), 30.0)):
        errors.look(*ping)
        assert k * PING_S < 16.0 or "is the sound speed right?" in errors.reasons()[0]


def test_a_convoy_on_the_vehicle_s_course_is_no_error_of_the_ranges() -> None:
    for seed, north in enumerate((0.2, 0.4, 0.8)):
        errors = CommonErrors()
        for ping in World(velocity=np.array([[north, 0.0]]), weave=0.0).pings(Wrong(), 15.0, seed):
            errors.look(*ping)
            assert not errors.reasons()


@pytest.mark.parametrize("latency", [-0.5, 0.5])
def test_poses_that_are_half_a_second_late_or_early_are_reported_in_turns(latency: float) -> None:
    _, reason = seconds_until(World(), Wrong(latency=latency), "poses are stamped", 15.0, 0)
    assert number(reason)[0] > 400.0
    assert ("early" in reason) == (latency > 0.0)


def test_a_sample_spacing_that_changes_is_a_reason_unless_static_objects_are_in_place() -> None:
    caution = "the sonar's sample spacing changes from ping to ping (0.05 to 0.055 m)"
    errors = CommonErrors()
    for seen, (snapshot, scan, motion) in enumerate(World().pings(Wrong(), 3.0), start=1):
        errors.look(replace(snapshot, times_seen=np.full_like(snapshot.times_seen, seen)), scan, motion)
        in_place = not errors.reasons(caution=caution)
        assert in_place == (seen > 5)
        assert not errors.reasons(caution="the sonar's sound speed changes from ping to ping (1480 to 1490 m/s)")
    assert in_place


def test_a_jump_of_the_pose_begins_anew() -> None:
    errors = after(World(), Wrong(yaw=math.radians(2.0), mirrored=True))
    assert errors.reasons()
    errors.begin_again()
    assert not errors.problem()
    assert not errors.reasons()


@pytest.mark.parametrize("spoil", [
    lambda s: replace(s, position=np.full_like(s.position, math.nan)),
    lambda s: s.take(np.arange(0)),
    lambda s: replace(s, radius=np.full_like(s.radius, 50.0)),
])  # fmt: skip
def test_what_tells_nothing_says_nothing(spoil: Callable[[Snapshot], Snapshot]) -> None:
    errors = CommonErrors()
    for snapshot, scan, motion in World().pings(Wrong(yaw=0.1), 10.0):
        errors.look(spoil(snapshot), scan, motion)
    assert not errors.problem()


def test_normal_equations_fade_and_rates_count_from_now() -> None:
    rng, sums = np.random.default_rng(3), FadingSums(2.0)
    expected: dict[int, Floats] = {}
    first: dict[int, Floats] = {}
    later = np.eye(WHOLE)
    later[YAW, TURN] = later[0, NORTH] = later[1, EAST] = -0.25
    for ping in range(8):
        ids = rng.permutation(5)[: rng.integers(1, 5)]
        n = len(ids)
        design, white = rng.normal(size=(n, 2, COLUMNS)), rng.normal(size=(n, 2, 2))
        seen = Sightings(ids, rng.normal(size=(n, 2)), design, white)
        sums.add(seen, 0.25 * (ping + 1))
        expected = {each: math.exp(-0.125) * later.T @ of @ later for each, of in expected.items()}
        for each, place, matrix, by in zip(ids.tolist(), *seen[1:], strict=True):
            start = first.setdefault(each, place)
            equations = by @ np.column_stack([matrix, place - start])
            expected[each] = expected.get(each, 0.0) + equations.T @ equations
    for each, of in zip(sums._id.tolist(), sums._sums, strict=True):
        np.testing.assert_allclose(of, expected[each], rtol=1e-9, atol=1e-9)


@given(st.integers(3, 12), st.integers(1, 3), st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=50)
def test_errors_fit_as_by_leaving_out_one_object_at_a_time(count: int, size: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    residuals = rng.normal(size=(count, 9, 7))
    information, freedom = residuals.swapaxes(1, 2) @ residuals, rng.uniform(1.0, 9.0, count)
    errors = tuple(int(each) + OWN for each in rng.permutation(6)[:size])
    columns = [each - OWN for each in errors]

    def fitted(kept: list[int]) -> tuple[Floats, float]:
        matrix, right = (information[kept][:, columns][:, :, each] for each in (columns, [6]))
        value = np.linalg.solve(matrix.sum(axis=0), right.sum(axis=0)[:, 0])
        all_errors = np.zeros(7)
        all_errors[columns], all_errors[6] = -value, 1.0
        return value, float(np.square(residuals[kept] @ all_errors).sum() / freedom[kept].sum())

    found = fit(Reduced(information, freedom), errors)
    assert found is not None
    value, left = fitted(list(range(count)))
    without = [fitted([k for k in range(count) if k != out]) for out in range(count)]
    jackknife = (count - 1) / (count - 2) * sum(np.square(each - value) for each, _ in without)
    covariance = np.linalg.inv(information[:, columns][:, :, columns].sum(axis=0)).diagonal()
    np.testing.assert_allclose(found.value, value, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.left, left, rtol=1e-6)
    np.testing.assert_allclose(found.left_without, [each for _, each in without], rtol=1e-6)
    np.testing.assert_allclose(found.sigma, np.sqrt(max(1.0, left) * covariance + jackknife), rtol=1e-6)


def test_errors_that_move_nothing_are_not_found() -> None:
    assert fit(Reduced(np.zeros((4, 7, 7)), np.ones(4)), (YAW,)) is None
