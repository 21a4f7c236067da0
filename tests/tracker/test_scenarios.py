"""The tracker on whole missions: the worked example of [SSIE] figures 6 and 7, fields, clutter, silence, return."""

import math

import numpy as np
import pytest

from ods.tracker.existence import lifecycle
from ods.tracker.map.map_object import MapObject
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.samples import HALF_VERTICAL, Course, Run, course, run, scan

VEHICLE_SPEED = 50.0 / 80.0


def fresh() -> Tracker:
    return Tracker(TrackerSettings())


@pytest.fixture(scope="module")
def example() -> tuple[Course, Run]:
    """[SSIE] section Observer: object 1 leaves the field of view at t = 41 s."""
    starts = np.array([[75.0, 4.3, 4.0], [60.0, -30.0, 4.0]])
    velocities = np.array([[-0.7, 0.4, 0.1], [0.5, 0.7, 0.1]])
    path = course(80.0, VEHICLE_SPEED, starts, velocities, np.array([3.0, 6.0]))
    return path, run(path, fresh())


def test_the_worked_example_has_two_objects(example: tuple[Course, Run]) -> None:
    path, result = example
    assert len(result.ids()) == 2
    for i in range(2):
        k = int(30.0 * 7)
        assert result.nearest(k, path.objects[k, i])[1] < 1.0


def test_object_1_goes_to_stand_by_when_it_leaves(example: tuple[Course, Run]) -> None:
    path, result = example
    first, _ = result.nearest(30 * 7, path.objects[30 * 7, 0])
    states = result.states(first)
    left = next(k for k in range(len(path.t)) if path.t[k] > 30.0 and not path.polar(k)[2][0])
    assert path.t[left] == pytest.approx(41.0, abs=1.0)
    stand_by = next(k for k, state in enumerate(states) if k > left - 14 and state == lifecycle.STAND_BY)
    assert path.t[stand_by] == pytest.approx(path.t[left], abs=1.0)
    # It is carried on where it went for ten seconds, and then given up: it moves, so it is not fit for a map.
    later = stand_by + 7 * 8
    assert states[later] == lifecycle.STAND_BY
    assert result.nearest(later, path.objects[later, 0])[1] < 3.0
    assert states[-1] == lifecycle.TENTATIVE
    assert [i for _, i in result.ended] == [first]


def test_radii_and_velocities_are_found(example: tuple[Course, Run]) -> None:
    path, result = example
    k = 40 * 7
    for i, (radius, velocity) in enumerate([(3.0, (-0.7, 0.4)), (6.0, (0.5, 0.7))]):
        picture = result.snapshots[k]
        row = int(np.flatnonzero(picture.id == result.nearest(k, path.objects[k, i])[0])[0])
        assert picture.radius[row] == pytest.approx(radius, abs=0.3)
        np.testing.assert_allclose(picture.velocity[:2, row], velocity, atol=0.15)


def test_the_height_is_not_observed_and_the_tracker_knows(example: tuple[Course, Run]) -> None:
    """The objects sink by 8 m, unseen; the true depth stays within two standard deviations reported."""
    path, result = example
    k = 40 * 7
    picture = result.snapshots[k]
    for i in range(2):
        row = int(np.flatnonzero(picture.id == result.nearest(k, path.objects[k, i])[0])[0])
        assert picture.sigma_position[2, row] > 2.0
        assert abs(picture.position[2, row] - path.objects[k, i, 2]) < 2.0 * picture.sigma_position[2, row]
        assert picture.sigma_velocity[2, row] > 0.2


def field(seed: int, count: int = 12) -> Course:
    rng = np.random.default_rng(seed)
    starts: list[list[float]] = []
    while len(starts) < count:
        place = [rng.uniform(20.0, 120.0), rng.uniform(-40.0, 40.0), 4.0]
        if all(math.dist(place, other) > 4.0 for other in starts):
            starts.append(place)
    return course(60.0, VEHICLE_SPEED, np.array(starts), np.zeros((count, 3)), rng.uniform(0.5, 2.0, count))


def test_a_static_field_is_mapped_exactly_and_does_not_move() -> None:
    path = field(5)
    result = run(path, fresh(), seed=5)
    seen = np.array([sum(path.polar(k)[2][i] for k in range(len(path.t))) for i in range(12)])
    found = [result.nearest(-1, path.objects[-1, i]) for i in range(12) if seen[i] > 30]
    assert len({i for i, _ in found}) == len(found) == len(result.ids())
    assert math.sqrt(np.mean([d**2 for _, d in found])) < 0.15
    last = result.snapshots[-1]
    assert np.hypot(*last.velocity[:2]).max() < 0.02
    assert set(last.state.tolist()) == {lifecycle.ACTIVE, lifecycle.HIBERNATED}


def test_errors_are_as_large_as_reported() -> None:
    """Normalised squared errors of static objects anywhere in the fan's height: mean 2, in its 99.9 % band."""
    errors = []
    for seed in range(8):
        path, rng = field(seed), np.random.default_rng(100 + seed)
        rise = np.tan(rng.uniform(-HALF_VERTICAL, HALF_VERTICAL, 12))
        path.objects[:, :, 2] = path.position[0, 2] + np.hypot(*path.objects[0, :, :2].T) * rise
        result = run(course(3.0, VEHICLE_SPEED, path.objects[0], np.zeros((12, 3)), path.radius), fresh(), seed)
        picture = result.snapshots[-1]
        for i in np.flatnonzero(path.polar(0)[2]):
            object_id, distance = result.nearest(-1, path.objects[0, i])
            if distance < 3.0:
                row = int(np.flatnonzero(picture.id == object_id)[0])
                offset = picture.position[:2, row] - path.objects[0, i, :2]
                spread = np.diag(picture.sigma_position[:2, row] ** 2)
                spread[0, 1] = spread[1, 0] = picture.covariance_ne[row]
                errors.append(float(offset @ np.linalg.solve(spread, offset)))
    assert len(errors) > 40
    assert np.mean(errors) == pytest.approx(2.0, abs=3.3 * 2.0 / math.sqrt(len(errors)))


@pytest.mark.parametrize("clutter", [10.0, 50.0])
def test_clutter_makes_no_objects(clutter: float) -> None:
    path = course(40.0, VEHICLE_SPEED, np.array([[50.0, 0.0, 4.0]]), np.zeros((1, 3)), np.array([1.0]))
    result = run(path, fresh(), seed=6, clutter=clutter)
    assert len(result.ids()) == 1
    assert result.nearest(-1, path.objects[-1, 0])[1] < 0.3


def test_a_drop_out_of_ten_seconds_costs_no_identity() -> None:
    path = field(7)
    result = run(path, fresh(), seed=7, silent=(20.0, 30.0))
    before, after = result.snapshots[20 * 7 - 1], result.snapshots[31 * 7]
    still_seen = np.flatnonzero(path.polar(20 * 7)[2] & path.polar(31 * 7)[2])
    assert len(still_seen) > 3
    for i in still_seen:
        k = 20 * 7 - 1
        assert result.nearest(k, path.objects[k, i])[0] == result.nearest(31 * 7, path.objects[0, i])[0]
    assert set(before.id.tolist()) >= set(after.id[after.first_seen_utc_ns < int(20e9)].tolist())


def test_crossing_objects_keep_their_identities() -> None:
    starts = np.array([[40.0, -12.0, 4.0], [40.0, 12.0, 4.0]])
    velocities = np.array([[0.1, 0.5, 0.0], [0.1, -0.5, 0.0]])
    path = course(48.0, VEHICLE_SPEED, starts, velocities, np.array([1.0, 1.2]))
    result = run(path, fresh(), seed=8)
    for i in range(2):
        assert result.nearest(70, path.objects[70, i])[0] == result.nearest(-1, path.objects[-1, i])[0]
    assert len(result.ids()) == 2


def test_objects_that_come_back_into_view_wake_with_their_ids() -> None:
    """Look at ten objects, turn away for 130 s, look again."""
    rng = np.random.default_rng(9)
    starts = np.column_stack([rng.uniform(30, 80, 10), np.arange(-20, 20, 4), np.full(10, 4.0)])
    path = course(165.0, 0.0, starts, np.zeros((10, 3)), np.full(10, 1.0))
    away = (path.t > 20.0) & (path.t < 150.0)
    path.yaw[away] = np.pi
    some = ~away | (np.arange(len(away)) % 7 == 0)  # fewer pings while there is nothing to see
    path = Course(path.t[some], path.position[some], path.yaw[some], path.objects[some], path.radius)
    result = run(path, fresh(), seed=9)
    asleep = result.snapshots[20 * 7 + 100]
    assert set(asleep.state.tolist()) == {lifecycle.HIBERNATED}
    assert not asleep.velocity.any()
    ids = {result.nearest(19 * 7, path.objects[0, i])[0] for i in range(10)}
    assert ids == {result.nearest(-1, path.objects[0, i])[0] for i in range(10)} == set(result.ids())
    assert set(result.snapshots[-1].state.tolist()) == {lifecycle.ACTIVE}


def test_objects_of_an_earlier_mission_wake_with_their_ids() -> None:
    rocks = [
        MapObject(41 + i, (40.0 + 10.0 * i, 0.4, 3.0), (0.6, 0.6, 2.0), 1.0, 0.1, 0.99, 50, 1, 2, 3) for i in range(2)
    ]
    tracker = Tracker(TrackerSettings(), rocks, first_id=100)
    assert tracker.snapshot().id.tolist() == [41, 42]
    path = course(
        5.0, 0.0, np.array([[40.0, 0.0, 4.0], [50.0, 0.0, 4.0], [60.0, 9.0, 4.0]]), np.zeros((3, 3)), np.ones(3)
    )
    result = run(path, tracker, seed=10)
    last = result.snapshots[-1]
    assert set(zip(last.id.tolist(), last.state.tolist(), strict=True)) == {(41, 1), (42, 1), (100, 1)}
    assert last.first_seen_utc_ns[last.id == 41] == 1


def test_two_echoes_of_one_large_object_make_no_second_one() -> None:
    """A cylinder of 6 m radius, found whole, then split into two halves off its centre for a while."""
    tracker, rng = fresh(), np.random.default_rng(11)
    ids = set()
    for k in range(140):
        noise = rng.normal(0.0, 0.1, 4)
        whole = [(50.0 + noise[0], noise[1] / 20, 6.0)]
        halves = [(50.0 + noise[0], 0.06 + noise[1] / 20, 3.0), (50.0 + noise[2], -0.06 + noise[3] / 20, 3.0)]
        tracker.step(scan(k / 7, np.zeros(3), 0.0, halves if 40 <= k < 100 else whole))
        ids |= set(tracker.snapshot().id.tolist())
    picture = tracker.snapshot()
    assert ids == {1}
    assert picture.radius[0] == pytest.approx(6.0, abs=0.5)
    assert np.hypot(*(picture.position[:2, 0] - [50.0, 0.0])) < 0.5


def test_without_a_pose_objects_are_only_carried_on() -> None:
    tracker = fresh()
    for k in range(10):
        tracker.step(scan(k / 7, np.zeros(3), 0.0, [(50.0, 0.0, 1.0)]))
    before = tracker.snapshot()
    blind = scan(10 / 7, np.zeros(3), 0.0, [(20.0, 0.0, 1.0)])
    tracker.step(type(blind)(blind.t_ns, blind.utc_ns, None, blind.sector, blind.echoes))
    after = tracker.snapshot()
    assert after.id.tolist() == before.id.tolist()
    assert after.times_seen.tolist() == before.times_seen.tolist()
    assert (after.sigma_position >= before.sigma_position).all()
