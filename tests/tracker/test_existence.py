"""The existence model: Bayes' rule by hand, each feature against its law, and what is learned of clutter."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.special import betaln
from scipy.stats import betabinom, logistic, norm

from ods.base.arrays import Floats
from ods.tracker.existence import ipda
from ods.tracker.existence.evidence import (
    CLUTTER_TRACKS,
    ENDED_TRACKS,
    LENGTH,
    STRENGTHS,
    ClutterStatistics,
    ExistenceTable,
)
from ods.tracker.existence.ipda import LEADING_EDGE, MOTION, ONSET, STRENGTH, ExistenceState, HitRates, Rates
from ods.tracker.existence.model import EXISTENCE
from ods.tracker.measurement.scan import LARGEST_PATCH_M, Echoes, echoes_of
from ods.tracker.settings import EchoSettings, TrackerSettings
from ods.tracker.state import TrackerState
from ods.tracker.tracker import Tracker
from tests.tracker.samples import RATE_HZ, SECTOR, scan
from tests.tracker.spots import told_after

M, ECHO = EXISTENCE, EchoSettings()


def knowing(values: dict[int, float]) -> ClutterStatistics:
    """Return statistics with these numbers at these places of the array."""
    clutter = ClutterStatistics()
    clutter.values[list(values)] = list(values.values())
    return clutter


@given(st.integers(0, 100_000), st.floats(0.0, 1e6))
def test_existence_stays_a_probability(seed: int, dt: float) -> None:
    rng, rates = np.random.default_rng(seed), Rates(ECHO.silence_rate, ECHO.return_rate, ECHO.loss_rate)
    for probabilities in rng.dirichlet(np.ones(4), 50).tolist():
        start = ExistenceState(*probabilities)
        later = ipda.predict(start, int(rng.integers(1, 1000)), rng.random(), dt, rates)
        often = ipda.hit_rate_ratio(np.floor(50.0 * rng.random()), 50.0 + 10.0 * rng.random(), 0.9, rng.random())
        updated = ipda.update(later, bool(rng.random() < 0.5), rng.normal(0.0, 50.0), 0.99 * rng.random(), often)
        judged = ipda.apply_likelihood_ratio(updated, rng.normal(0.0, 5.0), rng.normal(0.0, 5.0))
        for state in (later, updated, judged):
            assert sum(state) == pytest.approx(1.0)
            assert min(state) >= 0.0
        assert later.nothing >= start.nothing - 1e-12  # time alone gives no life


def test_bayes_by_hand() -> None:
    """Prior 0.2 visible, 0.3 silent, 0.4 nothing, 0.1 clutter; an object has an echo in 0.9 of the scans, clutter in
    0.45.

    An echo 9 times as likely from the object, at its setting of 0.9: (0.1 + 9) 0.2 : 0.3 : 0.4 : (0.55 + 4.5) 0.1. To
    the silent object the echo is a false alarm: it is no proof against it.
    """
    start, often = ExistenceState(0.2, 0.3, 0.4, 0.1), HitRates(1.0, 0.5)
    hit = ipda.update(start, True, math.log(9.0), 0.9, often)
    np.testing.assert_allclose(hit, np.array([1.82, 0.3, 0.4, 0.505]) / 3.025)
    missed = ipda.update(start, False, 0.0, 0.9, often)
    np.testing.assert_allclose(missed, np.array([0.02, 0.3, 0.4, 0.055]) / 0.775)


@pytest.mark.parametrize(("hits", "scans"), [(0, 3), (3, 3), (20, 40), (36, 40), (150, 200)])
@pytest.mark.parametrize("crowding", [0.0, 1.0])
def test_many_scans_prove_what_the_beta_binomial_law_says(hits: int, scans: int, crowding: float) -> None:
    """An object over clutter, whatever the order of hits and misses."""
    order = np.random.default_rng(1).permutation(np.arange(scans) < hits)
    state, seen, probability = ExistenceState(0.5, 0.0, 0.0, 0.5), 0.0, 0.9
    for k, hit in enumerate(order.tolist()):
        rates = ipda.hit_rate_ratio(seen, float(k), probability, crowding)
        # 1e6 times as likely as a false alarm, which then is no other explanation
        state = ipda.update(state, hit, math.log(1e6), probability, rates)
        seen += float(hit)

    def log_law(share: float, weight: float) -> float:
        a, b = weight * share, weight * (1.0 - share)
        return float(betaln(a + hits, b + scans - hits) - betaln(a, b))

    of_clutter = log_law(M.clutter_hit_rate, M.crowded_scans if crowding else M.clutter_scans)
    expected = log_law(M.object_hit_rate, M.object_scans) - of_clutter
    assert np.log(state.visible / state.clutter) == pytest.approx(expected, abs=1e-3)


def test_clutter_is_crowded_by_its_echoes_a_second() -> None:
    def crowding(echoes: float, dt: float) -> float:
        return knowing({STRENGTHS: echoes}).crowding(dt)

    assert crowding(0.1 * M.crowd_a_second, 0.1) == pytest.approx(0.5)
    assert crowding(10.0, 0.15) < 0.001, "a coarse sonar over rocks"
    assert crowding(40.0, 0.15) > 0.9, "three planes over ripples"
    assert crowding(0.0, 0.15) == crowding(10.0, 0.0) == 0.0, "nothing is known yet"


@pytest.mark.parametrize(("sharp", "echoes"), [(0, 1), (1, 1), (2, 5), (9, 12), (0, 3), (1, 8), (0, 40)])
def test_the_onsets_ratio_is_of_two_beta_binomial_laws(sharp: int, echoes: int) -> None:
    of_object = betabinom(echoes, M.object_sharp, M.object_slow).logpmf(sharp)
    of_clutter = betabinom(echoes, M.clutter_sharp, M.clutter_slow).logpmf(sharp)
    least = -M.onset_against if echoes >= M.onset_enough else 0.0
    onsets = [0.9 * M.sharp] * sharp + [1.1 * M.sharp] * (echoes - sharp)
    found = ipda.log_ratio(ONSET, onsets, ClutterStatistics())
    assert found == pytest.approx(np.clip(of_object - of_clutter, least, M.onset_for), abs=1e-6)


@pytest.mark.parametrize(("mean", "echoes"), [(1.0, 1), (6.0, 3), (2.0, 10), (-3.0, 10), (9.0, 10)])
def test_the_leading_edges_ratio_is_of_two_normal_laws(mean: float, echoes: int) -> None:
    counted = sum(M.edge_fade**k for k in range(echoes))
    sigma = np.sqrt(M.edge_variance * (1.0 + M.edge_few / counted))
    expected = norm(M.object_edge, sigma).logpdf(mean) - norm(M.clutter_edge, sigma).logpdf(mean)
    edges = [1.0 / (1.0 + math.exp(-mean))] * echoes
    found = ipda.log_ratio(LEADING_EDGE, edges, ClutterStatistics())
    assert found == pytest.approx(np.clip(expected, -M.edge_against, M.edge_for), abs=1e-6)


def echoes(rows: list[tuple[float, float]]) -> Echoes:
    """Of (range, strength)."""
    table = np.array([(r, 0.0, 0.0, 1.0, 0.1, 0.01, 0.3, strength) for r, strength in rows])
    return echoes_of(table.reshape(-1, 8))[0]


def count(clutter: ClutterStatistics, rows: list[tuple[float, float]]) -> None:
    """Take in a scan of echoes that no confirmed track explains."""
    clutter.count_strengths(echoes(rows), np.ones(len(rows), bool), SECTOR)


def test_the_strengths_ratio_is_of_an_even_density_and_a_logistic_one_of_the_echoes_around() -> None:
    """Two rings, three scans: mean and standard deviation of clutter put together by hand."""
    clutter, rng = ClutterStatistics(), np.random.default_rng(3)
    near, far = rng.normal(14.0, 1.0, (3, 8)), rng.normal(18.0, 2.0, (3, 4))
    for k in range(3):
        count(clutter, [(25.0, x) for x in near[k]] + [(75.0, x) for x in far[k]])
    fades = M.strength_memory ** np.array([2.0, 1.0, 0.0])
    values = np.concatenate([near.ravel(), far.ravel()])
    weights = np.concatenate([np.repeat(fades, 8), np.repeat(fades, 4)])
    for range_m, own, each in ((25.0, near, 8), (75.0, far, 4)):
        weight = np.concatenate([np.repeat(fades, each), M.pooled * weights / weights.sum()])
        value = np.concatenate([own.ravel(), values])
        mean = np.average(value, weights=weight)
        sigma = np.sqrt(np.average((value - mean) ** 2, weights=weight))
        known = each * fades.sum() / (each * fades.sum() + M.strength_few)
        for strengths in ([mean + 1.5], [mean + 3.0, mean + 2.0], [mean - 2.0]):
            excess = max(float(np.mean(strengths) - mean) / sigma, 0.0)
            spread = np.sqrt(M.lasting + (1.0 - M.lasting) / len(strengths))
            law = logistic(scale=spread * np.sqrt(3.0) / np.pi)
            expected = np.clip(-known * np.log(M.span_db * law.pdf(excess) / sigma), -7.0, 7.0)
            found = ipda.log_ratio(STRENGTH, strengths, clutter, range_m, SECTOR.range_max_m)
            assert found == pytest.approx(expected)


def test_nothing_is_said_without_echoes_or_of_strengths_that_nobody_measures() -> None:
    for feature in (ONSET, LEADING_EDGE, STRENGTH, MOTION):
        assert ipda.log_ratio(feature, [], ClutterStatistics()) == pytest.approx(0.0, abs=1e-12)
    clutter = ClutterStatistics()
    count(clutter, [(50.0, 0.0)] * 5)
    assert ipda.log_ratio(STRENGTH, [15.0], clutter, 50.0, SECTOR.range_max_m) == 0.0


def test_what_confirmed_tracks_explain_does_not_count() -> None:
    one, other = ClutterStatistics(), ClutterStatistics()
    one.count_strengths(echoes([(25.0, 14.0), (50.0, 16.0)]), np.array([True, False]), SECTOR)
    count(other, [(25.0, 14.0)])
    assert one.save() == other.save()


def table(**rows: float) -> Floats:
    """Return a table of two tracks with these rows."""
    values = [rows.get(name, 0.0) for name in ExistenceTable._fields]
    return np.repeat(np.array(values)[:, None], 2, axis=1)


def test_tracks_that_end_teach_what_clutter_is_like() -> None:
    """Of two tracks one ended, as clutter by 0.6 and as nothing by 0.3; then a scan in which nothing ends."""
    clutter = ClutterStatistics()
    tracks = table(visible=0.1, clutter=0.6, nothing=0.3)
    assert clutter.clutter_share == pytest.approx(M.calm_share)
    clutter.learn(tracks, np.array([True, False]))
    clutter.learn(tracks, np.zeros(2, bool))
    learned = clutter.values[[CLUTTER_TRACKS, ENDED_TRACKS]]
    np.testing.assert_allclose(learned, M.share_memory * np.array([0.6, 0.9]))
    share = (learned[0] + M.share_tracks * M.calm_share) / (learned[1] + M.share_tracks)
    assert clutter.clutter_share == pytest.approx(share)
    clutter.values[[CLUTTER_TRACKS, ENDED_TRACKS]] = 1e6
    assert clutter.clutter_share == M.most_share


def test_the_share_of_clutter_rises_with_echoes_that_measure_a_strength() -> None:
    clutter = ClutterStatistics()
    for _ in range(3):
        count(clutter, [(25.0, 14.0), (50.0, 16.0), (75.0, 19.0)])
    assert clutter.clutter_share == pytest.approx(M.calm_share + M.new_share * 9.0 / (9.0 + M.many**2))


def test_the_next_one_goes_on_with_the_same_statistics_and_refuses_nonsense() -> None:
    one, other = ClutterStatistics(), ClutterStatistics()
    count(one, [(25.0, 14.0), (75.0, 19.0)])
    one.learn(table(clutter=0.9, nothing=0.1), np.ones(2, bool))
    other.load(one.save())
    np.testing.assert_array_equal(one.values, other.values)
    for place, value in ((ENDED_TRACKS, np.nan), (CLUTTER_TRACKS, -1.0), (CLUTTER_TRACKS, 9.0), (STRENGTHS, np.inf)):
        bad = one.save()
        bad[place] = value
        with pytest.raises(ValueError, match="clutter statistics"):
            ClutterStatistics().load(bad)
    with pytest.raises(ValueError, match=f"not {LENGTH}"):
        ClutterStatistics().load(one.save()[:-1])


def test_a_new_track_needs_higher_odds_where_onsets_are_measured() -> None:
    tracks = table(visible=0.97, silent=0.02, nothing=0.006, clutter=0.004)
    assert ipda.confirmation_probability(tracks, 0) == pytest.approx(0.99)
    found = ipda.confirmation_probability(table(visible=0.97, silent=0.02, nothing=0.01, onsets=3.0), 0)
    assert found / (1.0 - found) == pytest.approx(99.0 / M.odds_factor)


def test_motion_is_for_an_object_and_never_against_one() -> None:
    """A ratio of the odds of rest before and now, up to a limit."""
    clutter = ClutterStatistics()
    assert ipda.log_ratio(MOTION, [0.1], clutter) == pytest.approx(math.log(0.5 / 0.1))
    assert ipda.log_ratio(MOTION, [1e-9], clutter) == M.motion_for
    assert ipda.log_ratio(MOTION, [0.1, 0.9], clutter) == 0.0


def told(onset: float) -> float:
    return told_after(0.1, onset=onset, of_spots=3.0 * M.sharp)


def test_what_sets_in_sharply_is_told_sooner_and_what_begins_slowly_later() -> None:
    assert told(0.8 * M.sharp) + 0.3 < told(0.0) < told(2.0 * M.sharp) - 0.3


def test_what_sets_in_as_an_object_does_is_told_sooner_and_a_crest_later() -> None:
    untold = told_after(0.1)
    assert told_after(0.1, front=0.99) + 0.3 < untold
    assert untold + 0.3 < told_after(0.1, front=0.02) < 10.0


def test_a_place_that_stays_takes_more_scans_in_a_crowd() -> None:
    assert told_after(0.1, rate_hz=10.0 * RATE_HZ) > told_after(0.1) + 0.5


def after_an_echo(radius: float, onset: float, front: float) -> TrackerState:
    """Return what is known after nine echoes of an object of 1 m, and one of this radius, m, onset and front."""
    tracker = Tracker(TrackerSettings())
    for k in range(10):
        image = scan(k / RATE_HZ, np.zeros(3), 0.0, [(60.0, 0.1, radius if k == 9 else 1.0)])
        rows = image.echoes.rows
        rows.strength[:], rows.onset[:], rows.front[:] = 13.0, 0.8 * M.sharp, 0.9
        if k == 9:
            rows.onset[:], rows.front[:] = onset, front
        tracker.step(image)
    return tracker.state()


@pytest.mark.parametrize(("onset", "front"), [(2.0 * M.sharp, 0.0), (0.0, 0.99)])
def test_an_echo_that_is_joined_with_neighbours_tells_nothing_of_how_it_sets_in(onset: float, front: float) -> None:
    assert after_an_echo(6.0, onset, front) == after_an_echo(6.0, 0.0, 0.0)
    assert after_an_echo(1.0, onset, front) != after_an_echo(1.0, 0.0, 0.0)


@pytest.mark.parametrize(("radius", "tells"), [(LARGEST_PATCH_M, True), (LARGEST_PATCH_M + 0.1, False)])
def test_what_is_larger_than_a_patch_of_bottom_tells_neither_onset_nor_front(radius: float, tells: bool) -> None:
    """A long wall that stands aslant to the beams sets in slowly, and is no clutter."""
    found, _ = echoes_of(np.array([[60.0, 0.1, 0.0, radius, 0.2, 0.01, 0.3, 25.0, 0.0, 0.0, 3.0, 0.02]]))
    assert (found.rows.onset[0] > 0.0, found.rows.front[0] > 0.0) == (tells, tells)


CALM_DB, BRIGHT_DB = 13.0, 20.0


def bed_with(body_db: float) -> Floats:
    """Return the times at which an object of that strength, at 60 m among lasting clutter of CALM_DB, is told; s."""
    rng, tracker, told = np.random.default_rng(2), Tracker(TrackerSettings()), []
    spots = [(rng.uniform(45.0, 75.0), rng.uniform(-0.7, 0.7), rng.uniform(0.2, 0.7)) for _ in range(30)]
    for k in range(round(20.0 * RATE_HZ)):
        lit = [spot[:2] for spot in spots if rng.random() < spot[2]]
        lit += [(60.0, 0.1)] * (k > 10.0 * RATE_HZ)
        rows = [(r + rng.normal(0, 0.1), b + rng.normal(0, 0.008), 1.0) for r, b in lit]
        image = scan(k / RATE_HZ, np.array([0.0, 0.0, 4.0]), 0.0, rows)
        image.echoes.rows.strength[:] = rng.normal(CALM_DB, 1.0, len(lit))
        if k > 10.0 * RATE_HZ:
            image.echoes.rows.strength[-1] += body_db - CALM_DB
        tracker.step(image)
        where = tracker.snapshot().position[:2] - 60.0 * np.array([[np.cos(0.1)], [np.sin(0.1)]])
        if (np.hypot(*where) < 1.5).any():
            told.append(k / RATE_HZ - 10.0)
    return np.array(told)


def test_an_object_stronger_than_the_bottom_is_told_at_once_and_one_as_weak_later() -> None:
    bright, weak = bed_with(BRIGHT_DB), bed_with(CALM_DB)
    assert 0.0 < bright[0] < 0.6
    assert len(weak) == 0 or weak[0] > bright[0]
