"""The observers against a textbook filter, each other and closed forms, and what no noise may break."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray

from ods.base.arrays import Floats
from ods.tracker.measurement.model import ATTITUDE, UNSEEN, PositionMeasurement
from ods.tracker.named import Named, TrackTables
from ods.tracker.observer.horizontal import STATE, Heights, NewPlaces
from ods.tracker.observer.kalman.imm import FACTORS, InteractingModels, Model
from ods.tracker.observer.motion_hypotheses import StaticOrMovingObserver
from ods.tracker.observer.registry import OBSERVERS, make_observer
from ods.tracker.settings import REST, MotionSettings
from tests.tracker.fixes import fixes_of

Long = NDArray[np.longdouble]
BOTH = np.array([0, 1])
DIAGONAL, LOWER = STATE, 2 * STATE
"""First of the rows of D, and of those of L below its diagonal, of a filter's factors."""


class MatrixFilter:
    """The textbook filter: full 4 x 4 matrices, extended precision, no trick."""

    def __init__(self, place: Floats, noise: Floats, velocity_variance: float) -> None:
        self.x: Long = np.zeros(4, np.longdouble)
        self.p: Long = np.zeros((4, 4), np.longdouble)
        self.x[:2], self.p[:2, :2] = place, noise
        self.p[2, 2] = self.p[3, 3] = velocity_variance

    def predict(self, dt: float, noise: float) -> None:
        h, one = np.longdouble(dt), np.eye(2, dtype=np.longdouble)
        f = np.kron(np.array([[1, h], [0, 1]], np.longdouble), one)
        q = np.longdouble(noise) * np.kron(np.array([[h**3 / 3, h**2 / 2], [h**2 / 2, h]], np.longdouble), one)
        self.x = f @ self.x
        self.p = f @ self.p @ f.T + q

    def update(self, place: Floats, noise: Floats) -> float:
        """Return the log of the density of `place`, times 2 pi."""
        s = self.p[:2, :2] + noise
        determinant = s[0, 0] * s[1, 1] - s[0, 1] ** 2
        inverse: Long = np.array([[s[1, 1], -s[0, 1]], [-s[0, 1], s[0, 0]]]) / determinant
        innovation = place - self.x[:2]
        density = -0.5 * (innovation @ inverse @ innovation + np.log(determinant))
        gain = self.p[:, :2] @ inverse
        self.x = self.x + gain @ innovation
        keep = np.eye(4, dtype=np.longdouble)
        keep[:, :2] -= gain
        self.p = keep @ self.p @ keep.T + gain @ noise @ gain.T
        return float(density)


def noise_of(along: float, across: float, angle: float) -> Floats:
    """Return the (2, 2) noise of a sonar that looks along `angle`."""
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    matrix: Floats = turn @ np.diag([along, across]) @ turn.T
    return matrix


def covariance_of(s: Floats, i: int = 0) -> Floats:
    """Return P = L D L' of column i."""
    lower = np.eye(4)
    lower[np.tril_indices(4, -1)] = s[LOWER:FACTORS, i]
    matrix: Floats = lower @ np.diag(s[DIAGONAL:LOWER, i]) @ lower.T
    return matrix


fixes = st.tuples(
    st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.floats(1e-3, 1e2), st.floats(1e-3, 1e2), st.floats(-3.2, 3.2)
)
steps = st.lists(st.tuples(st.floats(0.0, 30.0), st.one_of(st.none(), fixes)), min_size=1, max_size=30)


def begun(filters: InteractingModels, places: Floats, noise: Floats) -> Floats:
    """Append objects; return (hypotheses, FACTORS, k) states and factors: a view until more are appended."""
    reported = fixes_of(places, noise)
    TrackTables(filters.tables()).extend(places.shape[1])
    filters.start(NewPlaces(places, noise[:2], noise[2], reported.sensitivity))
    table: Floats = filters.tables()[0].table
    return table


def correct(filters: InteractingModels, reported: PositionMeasurement, since_s: float = 0.0) -> None:
    """Take one measurement of each object, whose heights are known."""
    count = len(reported.height)
    heights = Named(Heights, np.zeros((5, 2, count)))
    filters.update(np.arange(count), reported, np.full(count, since_s), heights)


@settings(max_examples=100, deadline=None)
@given(steps, st.floats(0.0, 10.0))
def test_the_factored_form_equals_the_matrix_form(
    sequence: list[tuple[float, tuple[float, float, float, float, float] | None]], noise: float
) -> None:
    first = noise_of(0.01, 0.8, 0.6)
    begin = np.array([[3.0], [-2.0]])
    filters = InteractingModels(MotionSettings(velocity_sigma=math.sqrt(0.5)), [Model(noise, 1.0)])
    s = begun(filters, begin, first[[0, 1, 0], [0, 1, 1], None])[1]
    textbook = MatrixFilter(begin[:, 0], first, 0.5)
    leaning = filters.tables()[2].table[1, ATTITUDE]
    for dt, fix in sequence:
        filters.predict(dt)
        textbook.predict(dt, noise)
        if fix:
            where, r = np.array(fix[:2]), noise_of(*fix[2:])
            reported = fixes_of(where[:, None], r[[0, 1, 0], [0, 1, 1], None])
            # A derivative that is the state, and is reported the place, follows with the same gain.
            leaning[:], reported.sensitivity[ATTITUDE, :, 0] = s[:STATE], where
            correct(filters, reported)
            textbook.update(where, r)
            np.testing.assert_allclose(leaning, s[:STATE], rtol=1e-12, atol=1e-12)
    truth = textbook.p.astype(np.float64)
    scale = np.sqrt(np.outer(np.diag(truth), np.diag(truth)))
    assert (np.abs(covariance_of(s) - truth) <= 1e-8 * scale).all()
    np.testing.assert_allclose(s[:STATE, 0], textbook.x.astype(np.float64), rtol=1e-7, atol=1e-6)
    # What is reported of parts of the state is that of the whole.
    state, (velocity, velocity_variance) = filters.state(), filters.velocity()
    np.testing.assert_array_equal([*state.position[1, :, 0], *velocity[:, 0]], s[:STATE, 0])
    told_variances = *state.variance[1, :, 0], state.covariance_ne[1, 0]
    np.testing.assert_allclose(told_variances, truth[[0, 1, 0], [0, 1, 1]], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(velocity_variance[:, 0], truth[[2, 3], [2, 3]], rtol=1e-6)


def test_it_stays_positive_definite_whatever_the_noise() -> None:
    """Millions of updates: intervals from 1e-9 to 1e5 s, noise from 1e-12 to 1e12 m^2 in any direction, at 1e6 m."""
    rng, count = np.random.default_rng(1), 1000
    models = [Model(10.0**exponent, 0.2) for exponent in (-6, -4, -2, 0, 2)]
    filters = InteractingModels(MotionSettings(velocity_sigma=1e3), models)
    s = begun(filters, np.full((2, count), 1e6), np.repeat([[1e-12], [1e-12], [0.0]], count, axis=1))
    for _ in range(1000):
        along, across = 10.0 ** rng.uniform(-12, 12, (2, count))
        angle = rng.uniform(-np.pi, np.pi, count)
        north, east = np.cos(angle), np.sin(angle)
        r = np.stack(
            [
                north**2 * along + east**2 * across,
                east**2 * along + north**2 * across,
                north * east * (along - across),
            ]
        )
        filters.predict(float(10.0 ** rng.uniform(-9, 5)))
        correct(filters, fixes_of(1e6 + rng.normal(0.0, 1.0, (2, count)), r))
        assert (s[1:, DIAGONAL:LOWER] > 0.0).all()
    assert np.isfinite(s).all()


def exchanged(shares: Floats, usual: Floats, stay: float, s: Floats, unseen: Floats) -> Floats:
    """Let two models of one object, at rest in `s` and `unseen`, exchange their states; return their shares then."""
    models = [Model(1.0, share) for share in usual.tolist()]
    filters = InteractingModels(MotionSettings(), models, -math.log(stay))
    begun(filters, np.zeros((2, 1)), np.array([[1.0], [1.0], [0.0]]))
    tables = [table.table for table in filters.tables()]
    for table, given_numbers in zip(tables, (s, shares, unseen), strict=False):
        table[:] = given_numbers
    correct(filters, fixes_of(np.zeros((2, 1)), np.array([[1e30], [1e30], [0.0]])), since_s=1.0)  # which tells nothing
    s[:], unseen[:] = tables[0], tables[2]
    return np.asarray(tables[1][:, 0])


def test_mixing_gives_mean_and_covariance_of_the_moment_match() -> None:
    rng = np.random.default_rng(2)
    s = rng.uniform(0.2, 2.0, (3, FACTORS, 1))
    shares, usual, stay = np.array([[0.3], [0.7]]), np.array([0.9, 0.1]), 0.8
    unseen = rng.uniform(-1.0, 1.0, (3, UNSEEN, STATE, 1))
    leaning = unseen[1:, :, :, 0].copy()
    before = [(s[1 + m, :STATE, 0].copy(), covariance_of(s[1 + m])) for m in range(2)]
    after = exchanged(shares, usual, stay, s, unseen)
    into = stay * np.eye(2) + (1.0 - stay) * usual[None, :]
    share = np.array([0.3, 0.7]) @ into
    np.testing.assert_allclose(after, share)
    for to in range(2):
        came = np.array([0.3, 0.7]) * into[:, to] / share[to]
        mean = sum(w * x for w, (x, _) in zip(came, before, strict=True))
        spread = sum(w * (p + np.outer(x - mean, x - mean)) for w, (x, p) in zip(came, before, strict=True))
        np.testing.assert_allclose(s[1 + to, :STATE, 0], mean)
        np.testing.assert_allclose(covariance_of(s[1 + to]), spread)
        np.testing.assert_allclose(unseen[1 + to, :, :, 0], np.tensordot(came, leaning, 1))


def test_what_is_of_next_to_no_weight_does_not_widen_a_model() -> None:
    rng = np.random.default_rng(3)
    s = rng.uniform(0.2, 2.0, (3, FACTORS, 1))
    unseen = rng.uniform(-1.0, 1.0, (3, UNSEEN, STATE, 1))
    shares, usual, stay = np.array([[0.95], [0.05]]), np.array([0.9, 0.1]), 0.97
    state, covariance, leaning = s[1, :STATE, 0].copy(), covariance_of(s[1]), unseen[1].copy()
    other = s[2, :STATE, 0].copy()
    after = exchanged(shares, usual, stay, s, unseen)
    np.testing.assert_allclose(after, [0.97 * 0.95 + 0.03 * 0.9, 0.97 * 0.05 + 0.03 * 0.1])
    np.testing.assert_allclose(s[1, :STATE, 0], state)
    np.testing.assert_allclose(covariance_of(s[1]), covariance)
    np.testing.assert_allclose(unseen[1], leaning)
    assert (s[2, :STATE, 0] != other).all(), "the other way the share is large"


def test_no_time_changes_nothing() -> None:
    observer = track(make_observer("manoeuvring", MotionSettings()), angle=0.7)
    before = [table.table.copy() for table in observer.tables()]
    observer.predict(0.0)
    for table, was in zip(observer.tables(), before, strict=True):
        np.testing.assert_array_equal(table.table, was)


def measured_at(places: Floats, along: float, across: float, angle: float) -> PositionMeasurement:
    """Return measurements of objects at (2, k), all with the same noise."""
    ones, r = np.ones(places.shape[1]), noise_of(along, across, angle)
    position = np.vstack([places, np.zeros_like(ones)])
    noise = r[0, 0] * ones, r[1, 1] * ones, r[0, 1] * ones
    level = 0.0 * ones, np.zeros((2, len(ones))), np.zeros((UNSEEN, 2, len(ones))), np.zeros(2)
    return PositionMeasurement(position, *noise, 3.0 * ones, ones, 0.1 * ones, *level)


def start(observer: StaticOrMovingObserver, measured: PositionMeasurement) -> None:
    TrackTables(observer.tables()).extend(len(measured.radius))
    observer.start(measured)


def recall(observer: StaticOrMovingObserver, *known: Floats) -> None:
    TrackTables(observer.tables()).extend(1)
    observer.recall(*known)


def track(observer: StaticOrMovingObserver, angle: float, seed: int = 3, speed: float = 0.8) -> StaticOrMovingObserver:
    """Show it one object at rest and one that moves, 60 times."""
    rng = np.random.default_rng(seed)
    spread = np.linalg.cholesky(noise_of(0.01, 0.25, angle))
    for k in range(60):
        truth = np.array([[20.0, 40.0 + speed * k / 7.0], [5.0, -3.0 - 0.5 * speed * k / 7.0]])
        measured = measured_at(truth + spread @ rng.standard_normal((2, 2)), 0.01, 0.25, angle)
        if k == 0:
            start(observer, measured)
        else:
            observer.predict(1.0 / 7.0)
            observer.update(BOTH, measured, np.full(2, 1.0 / 7.0))
    return observer


def moments_of(observer: StaticOrMovingObserver) -> Floats:
    """Return all that it tells as one table."""
    return np.vstack([*observer.belief_and_moments()[1], *observer.velocity()])


def test_without_mixed_noise_coupled_equals_independent() -> None:
    motion = MotionSettings()
    coupled, independent = (track(make_observer(name, motion), angle=0.0) for name in ("coupled", "independent"))
    np.testing.assert_allclose(moments_of(coupled), moments_of(independent), rtol=1e-9, atol=1e-12)


def test_models_all_alike_are_one() -> None:
    motion = MotionSettings()
    two = InteractingModels(motion, [Model(motion.acceleration_noise, 0.7), Model(motion.acceleration_noise, 0.3)], 0.1)
    one = track(make_observer("coupled", motion), angle=0.7)
    np.testing.assert_allclose(
        moments_of(track(StaticOrMovingObserver(motion, two), angle=0.7)), moments_of(one), rtol=1e-9, atol=1e-12
    )


def test_models_exchange_once_a_second_and_no_two_objects_wait_for_each_other() -> None:
    """Change so often that an exchange leaves the usual shares: those of objects that did not exchange stay."""
    motion, count, dt = MotionSettings(), 100, 1.0 / 7.0
    alike = Model(motion.acceleration_noise, 0.7), Model(motion.acceleration_noise, 0.3)
    filters = InteractingModels(motion, alike, 1e6)
    observer = StaticOrMovingObserver(motion, filters)
    places = np.zeros((2, count))
    start(observer, measured_at(places, 0.01, 0.01, 0.0))
    share = filters.tables()[1].table
    share[0], share[1] = 0.1, 0.9
    exchanged = []
    for _ in range(8):
        observer.predict(dt)
        observer.update(np.arange(count), measured_at(places, 0.01, 0.01, 0.0), np.full(count, dt))
        exchanged.append(int((np.abs(share[0] - 0.7) < 1e-6).sum()))
    assert exchanged[-1] == count
    assert np.diff([0, *exchanged]).max() <= 20


def errors_in_a_turn(observer: StaticOrMovingObserver) -> tuple[float, float]:
    """Return the rms error, m, before and in a turn, of objects that go straight at 1 m/s for 30 s and then turn."""
    rng, dt, straight, scans, count = np.random.default_rng(5), 1.0 / 7.0, 210, 280, 40
    course = 0.25 * np.maximum(np.arange(scans) - straight, 0) * dt
    truth = np.cumsum(np.stack([np.cos(course), np.sin(course)]) * dt, axis=1)
    squares = np.zeros(scans)
    for k in range(scans):
        places = truth[:, k : k + 1] + 0.3 * rng.standard_normal((2, count))
        measured = measured_at(places, 0.09, 0.09, 0.0)
        if k == 0:
            start(observer, measured)
        else:
            observer.predict(dt)
            observer.update(np.arange(count), measured, np.full(count, dt))
        squares[k] = np.mean((observer.belief_and_moments()[1].position[:2] - truth[:, k : k + 1]) ** 2)
    return float(np.sqrt(squares[straight - 70 : straight].mean())), float(np.sqrt(squares[straight + 20 :].mean()))


def test_several_models_follow_a_turn_and_a_straight_course() -> None:
    motion = MotionSettings()
    steady_only = StaticOrMovingObserver(motion, InteractingModels(motion, [Model(motion.steady_noise, 1.0)]))
    both, compromise = (errors_in_a_turn(make_observer(name, motion)) for name in ("manoeuvring", "coupled"))
    assert both[0] < 0.8 * compromise[0]
    assert both[1] < min(compromise[1], 0.3 * errors_in_a_turn(steady_only)[1])


@pytest.mark.parametrize("name", OBSERVERS)
def test_what_rests_and_what_moves_is_found(name: str) -> None:
    observer = track(make_observer(name, MotionSettings()), angle=0.7)
    belief, (velocity, _) = observer.belief_and_moments()[0], observer.velocity()
    np.testing.assert_allclose(belief.weight.sum(axis=0), 1.0)
    assert belief.static[0] > 0.95
    assert belief.static[1] < 0.05
    np.testing.assert_allclose(velocity[:2, 1], [0.8, -0.4], atol=0.15)
    observer.settle(BOTH)
    observer.predict(1000.0)
    assert observer.belief_and_moments()[0].static.tolist() == [1.0, 0.0]
    np.testing.assert_allclose(observer.belief_and_moments()[1].position[:2, 0], [20.0, 5.0], atol=0.4)


def test_what_hardly_moves_and_may_rest_is_settled_to_rest() -> None:
    """Chance makes an object at rest seem to creep; taken for one that moves, it was given up when out of view."""
    rng, dt, row = np.random.default_rng(3), 1.0 / 7.0, np.zeros(1, np.intp)
    observer = make_observer("manoeuvring", MotionSettings())
    start(observer, measured_at(np.zeros((2, 1)), 0.01, 0.01, 0.0))
    for k in range(1, 1000):
        observer.predict(dt)
        place = np.array([[0.02 * dt * max(k - 150, 0)], [0.0]]) + 0.1 * rng.standard_normal((2, 1))
        observer.update(row, measured_at(place, 0.01, 0.01, 0.0), np.full(1, dt))
        if k > 150 and observer.belief_and_moments()[0].static[0] < 0.4:
            break
    assert 0.05 < observer.belief_and_moments()[0].static[0] < 0.5
    observer.settle(row)
    assert observer.belief_and_moments()[0].static[0] == 1.0


@pytest.mark.parametrize("name", OBSERVERS)
def test_what_is_seen_again_goes_on_from_what_was_settled(name: str) -> None:
    observer = track(make_observer(name, MotionSettings()), angle=0.7)
    observer.settle(BOTH)
    before = observer.belief_and_moments()[1]
    observer.reopen(BOTH)
    belief = observer.belief_and_moments()[0]
    assert ((belief.static > 0.0) & (belief.static < 1.0)).all()
    # The hypothesis given up starts where the other one is.
    for h in range(len(belief.weight)):
        np.testing.assert_allclose(belief.position[h, :, 0], before.position[:, 0])
    np.testing.assert_allclose(belief.position[0, :2, 1], before.position[:2, 1], atol=0.1)


@pytest.mark.parametrize("name", OBSERVERS)
def test_the_map_is_taken_as_it_is(name: str) -> None:
    observer = make_observer(name, MotionSettings())
    position, variance = np.array([[10.0], [20.0], [3.0]]), np.array([[0.5], [0.4], [1.0]])
    recall(observer, position, variance, np.array([0.3]), np.array([1.5]), np.array([0.2]))
    recall(observer, position, np.zeros((3, 1)), np.zeros(1), np.array([1.5]), np.zeros(1))
    estimate = observer.belief_and_moments()[1]
    np.testing.assert_allclose(estimate.position, np.repeat(position, 2, axis=1))
    np.testing.assert_allclose(estimate.variance[:, 0], variance[:, 0])
    np.testing.assert_allclose(estimate.covariance_ne[0], 0.3)
    assert (estimate.variance[:, 1] > 0.0).all()
    assert (estimate.static == 1.0).all()


@pytest.mark.parametrize("name", OBSERVERS)
def test_an_heir_rests_where_the_old_object_did(name: str) -> None:
    observer = make_observer(name, MotionSettings())
    recall(observer, np.full((3, 1), 1.0), np.ones((3, 1)), np.full(1, 0.5), np.ones(1), np.ones(1))
    start(observer, measured_at(np.full((2, 1), 2.0), 1.5, 0.5, np.pi / 4.0))
    before = observer.belief_and_moments()[0].static[1]
    observer.inherit(np.array([1]), np.array([0]))
    belief = observer.belief_and_moments()[0]
    assert belief.static[1] > before
    np.testing.assert_allclose(belief.position[0, :2, 1], 1.5)
    np.testing.assert_allclose(belief.variance[0, :2, 1], 0.5)


@pytest.mark.parametrize("name", OBSERVERS)
def test_an_heir_of_what_moves_is_not_taken_to_rest(name: str) -> None:
    observer = track(make_observer(name, MotionSettings()), angle=0.7)
    observer.settle(BOTH)
    (moving,) = np.flatnonzero(observer.belief_and_moments()[0].static == 0.0)
    start(observer, measured_at(np.full((2, 1), 2.0), 1.5, 0.5, np.pi / 4.0))
    assert observer.belief_and_moments()[0].static[2] > REST
    observer.inherit(np.array([2]), np.array([moving]))
    assert observer.belief_and_moments()[0].static[2] < 0.1


extreme = st.lists(
    st.tuples(
        st.one_of(st.just(0.0), st.floats(1e-9, 1e5)),
        st.floats(-12.0, 6.0),
        st.floats(-12.0, 6.0),
        st.floats(-3.2, 3.2),
        st.floats(-1e6, 1e6),
        st.sampled_from(["update", "settle", "reopen", "rest", "inherit"]),
    ),
    min_size=1,
    max_size=30,
)


@pytest.mark.parametrize("name", OBSERVERS)
@settings(max_examples=60, deadline=None)
@given(sequence=extreme)
def test_whatever_happens_all_stays_finite(
    name: str, sequence: list[tuple[float, float, float, float, float, str]]
) -> None:
    observer = make_observer(name, MotionSettings())
    start(observer, measured_at(np.zeros((2, 2)), 0.01, 1.0, 0.5))
    for dt, along, across, angle, place, action in sequence:
        observer.predict(dt)
        if action == "inherit":
            observer.inherit(BOTH[:1], BOTH[1:])
        elif action == "update":
            observer.reopen(BOTH)
            observer.update(BOTH, measured_at(np.full((2, 2), place), 10.0**along, 10.0**across, angle), np.full(2, dt))
        else:
            getattr(observer, action)(BOTH)
        belief = observer.belief_and_moments()[0]
        np.testing.assert_allclose(belief.weight.sum(axis=0), 1.0)
        assert np.isfinite(moments_of(observer)).all()
        assert (belief.variance > 0.0).all()
        limit = np.sqrt(belief.variance[:, 0] * belief.variance[:, 1])
        assert (np.abs(belief.covariance_ne) <= limit * (1.0 + 1e-9)).all()
        assert (observer.velocity()[1] >= 0.0).all()
