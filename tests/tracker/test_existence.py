"""The existence model: Bayes' rule by hand, each feature against its law, and what is learned of clutter."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.special import betaln
from scipy.stats import betabinom, norm

from ods.base.arrays import Floats, Mask
from ods.compiled import native
from ods.tracker.existence.evidence import (
    CLUTTER_TRACKS,
    ECHOES,
    ENDED_TRACKS,
    LENGTH,
    ClutterStatistics,
    ExistenceTable,
)
from ods.tracker.existence.lifecycle import ACTIVE, TENTATIVE
from ods.tracker.existence.model import EXISTENCE, MODEL
from ods.tracker.measurement.scan import Echoes, echoes_of
from ods.tracker.restart.state import TrackerState
from ods.tracker.settings import EchoSettings, LifeSettings, TrackerSettings
from ods.tracker.track.tracks import History
from ods.tracker.tracker import Tracker
from tests.tracker.judged import EVEN, states_after, table, take_scan
from tests.tracker.samples import RATE_HZ, scan
from tests.tracker.spots import told_after

M, ECHO = EXISTENCE, EchoSettings()


@given(st.integers(0, 100_000), st.floats(0.0, 1e6))
def test_existence_stays_a_probability(seed: int, dt: float) -> None:
    rng, n = np.random.default_rng(seed), 50
    tracks = table(n, clutter_share=0.5)
    tracks[:4] = rng.dirichlet(np.ones(4), n).T
    scans = 60.0 * rng.random(n)
    named = ExistenceTable(*tracks)
    named.scans[:], named.hits[:] = scans, scans * rng.random(n)
    before = named.nothing.copy()
    watched = rng.random(n)
    take_scan(tracks, False, {"watched": watched}, dt=dt, echoes=int(rng.integers(1, 1000)))
    assert (named.nothing >= before - 1e-12).all()  # time alone gives no life
    of_echo = {"onset": 2.0 * rng.random(n), "leading_edge": rng.random(n), "llr": rng.normal(0.0, 50.0, n)}
    reported = {"watched": watched, "expected": 0.9 * watched, **of_echo}
    take_scan(tracks, rng.random(n) < 0.5, reported, at_rest=rng.random())
    np.testing.assert_allclose(tracks[:4].sum(axis=0), 1.0)
    assert (tracks[:4] >= 0.0).all()


def test_bayes_by_hand() -> None:
    """Prior 0.2 visible, 0.3 silent, 0.4 nothing, 0.1 clutter; 3 of 4 scans had an echo, and an echo is 9 times as
    likely from the object at its setting of 0.9. To the silent object an echo is a false alarm: no proof against it.
    """
    reported = {"llr": math.log(9.0), "watched": 1.0, "expected": ECHO.detection_probability}
    b = (3.0 + M.object_scans * M.object_hit_rate) / (4.0 + M.object_scans)
    s = (3.0 + M.clutter_scans * M.clutter_hit_rate) / (4.0 + M.clutter_scans)
    for hit, of_object, of_clutter in ((True, 1.0 - b + 10.0 * b, 1.0 - s + 10.0 * s), (False, 1.0 - b, 1.0 - s)):
        tracks = table(visible=0.2, silent=0.3, nothing=0.4, clutter=0.1, hits=3.0, scans=4.0)
        take_scan(tracks, hit, reported)
        expected = np.array([0.2 * of_object, 0.3, 0.4, 0.1 * of_clutter])
        np.testing.assert_allclose(tracks[:4, 0], expected / expected.sum())


@pytest.mark.parametrize(("hits", "scans"), [(0, 3), (3, 3), (20, 40), (36, 40), (150, 200)])
@pytest.mark.parametrize("crowded", [False, True])
def test_many_scans_prove_what_the_beta_binomial_law_says(hits: int, scans: int, crowded: bool) -> None:
    """An object over clutter, whatever the order of hits and misses."""
    tracks, counts = table(visible=0.5, clutter=0.5), np.zeros(LENGTH)
    counts[ECHOES] = 1e6 if crowded else 0.0
    for hit in np.random.default_rng(1).permutation(np.arange(scans) < hits).tolist():
        # 1e6 times as likely as a false alarm, which then is no other explanation; so soon that nothing else happens
        reported = {"llr": math.log(1e6), "watched": 1.0, "expected": ECHO.detection_probability}
        judged = take_scan(tracks, hit, reported, dt=1e-9, counts=counts)

    def log_law(share: float, weight: float) -> float:
        a, b = weight * share, weight * (1.0 - share)
        return float(betaln(a + hits, b + scans - hits) - betaln(a, b))

    of_clutter = log_law(M.clutter_hit_rate, M.crowded_scans if crowded else M.clutter_scans)
    expected = log_law(M.object_hit_rate, M.object_scans) - of_clutter
    assert np.log(judged.visible / judged.clutter)[0] == pytest.approx(expected, abs=1e-3)


def test_clutter_is_crowded_by_its_echoes_a_second() -> None:
    def proof(echoes: float, dt: float) -> float:
        """Return what a third echo in a row proves."""
        counts, tracks = np.zeros(LENGTH), table(visible=0.5, clutter=0.5, hits=2.0, scans=2.0)
        counts[ECHOES] = echoes
        judged = take_scan(tracks, True, {"llr": 20.0, "watched": 1.0, "expected": 0.9}, dt=dt, counts=counts)
        return float(np.log(judged.visible / judged.clutter)[0])

    alone, crowded = proof(0.0, 0.15), proof(1e6, 0.15)
    assert proof(10.0, 0.15) == pytest.approx(alone, abs=1e-3), "a coarse sonar over rocks"
    assert proof(40.0, 0.15) == pytest.approx(crowded, rel=0.1), "three planes over ripples"
    assert crowded < alone - 0.05


def judged_by(measured: str, echoes: list[float]) -> ExistenceTable:
    """Return a track after these echoes, of which one thing is measured."""
    tracks = table(visible=0.5, clutter=0.5)
    for echo in echoes:
        take_scan(tracks, True, {measured: echo})
    return ExistenceTable(*tracks)


@pytest.mark.parametrize(("sharp", "echoes"), [(0, 1), (1, 1), (2, 5), (9, 12), (0, 3), (1, 8), (0, 40)])
def test_the_onsets_ratio_is_of_two_beta_binomial_laws(sharp: int, echoes: int) -> None:
    of_object = betabinom(echoes, M.object_sharp, M.object_slow).logpmf(sharp)
    of_clutter = betabinom(echoes, M.clutter_sharp, M.clutter_slow).logpmf(sharp)
    least = -np.inf if echoes >= M.onset_enough else 0.0
    onsets = [0.9 * M.sharp] * sharp + [1.1 * M.sharp] * (echoes - sharp)
    found = judged_by("onset", onsets).onset_ratio[0]
    assert found == pytest.approx(np.clip(of_object - of_clutter, least, M.most_ratio), abs=1e-6)


@pytest.mark.parametrize(("mean", "echoes"), [(1.0, 1), (6.0, 3), (2.0, 10), (-3.0, 10), (9.0, 10)])
def test_the_leading_edges_ratio_is_of_two_normal_laws(mean: float, echoes: int) -> None:
    counted = sum(M.edge_fade**k for k in range(echoes))
    sigma = np.sqrt(M.edge_variance * (1.0 + M.edge_few / counted))
    expected = norm(M.object_edge, sigma).logpdf(mean) - norm(M.clutter_edge, sigma).logpdf(mean)
    found = judged_by("leading_edge", [1.0 / (1.0 + math.exp(-mean))] * echoes).edge_ratio[0]
    assert found == pytest.approx(np.clip(expected, -M.most_ratio, M.edge_for), abs=1e-6)


def echoes(strengths: list[float]) -> Echoes:
    """Return echoes of these strengths, dB."""
    table = np.array([(50.0, 0.0, 0.0, 1.0, 0.1, 0.01, 0.3, strength) for strength in strengths])
    return echoes_of(table.reshape(-1, 8))[0]


def count(clutter: ClutterStatistics, strengths: list[float]) -> None:
    """Take in a scan of echoes that no confirmed track explains."""
    native.clutter_count_echoes(clutter.values, echoes(strengths).table, np.ones(len(strengths), bool), MODEL)


def learn(clutter: ClutterStatistics, tracks: Floats, ended: Mask) -> None:
    """Take in a scan that ends tracks of a table."""
    native.clutter_learn(clutter.values, tracks, ended, MODEL)


def test_echoes_of_confirmed_tracks_or_without_a_strength_do_not_count() -> None:
    one, other = ClutterStatistics(), ClutterStatistics()
    free = np.array([True, False, True])
    native.clutter_count_echoes(one.values, echoes([14.0, 16.0, 0.0]).table, free, MODEL)
    count(other, [14.0])
    assert one.save() == other.save()
    assert other.values[ECHOES] == 1.0


def share_of(clutter: ClutterStatistics) -> float:
    """Return the share of clutter by which a new track is judged."""
    tracks, one = table(), np.ones(1)
    native.existence_begin(tracks, 0, 0.03, one, np.zeros((12, 1)), clutter.values, MODEL)
    return float(ExistenceTable(*tracks).clutter_share[0])


def test_tracks_that_end_teach_what_clutter_is_like() -> None:
    """Of two tracks one ended, as clutter by 0.6 and as nothing by 0.3; then a scan in which nothing ends."""
    clutter = ClutterStatistics()
    tracks = table(2, visible=0.1, clutter=0.6, nothing=0.3)
    calm = 0.1 * M.new_share / M.many**2
    assert share_of(clutter) == pytest.approx(calm)
    learn(clutter, tracks, np.array([True, False]))
    learn(clutter, tracks, np.zeros(2, bool))
    learned = clutter.values[[CLUTTER_TRACKS, ENDED_TRACKS]]
    np.testing.assert_allclose(learned, M.memory * np.array([0.6, 0.9]))
    share = (learned[0] + M.share_tracks * calm) / (learned[1] + M.share_tracks)
    assert share_of(clutter) == pytest.approx(share)
    clutter.values[[CLUTTER_TRACKS, ENDED_TRACKS]] = 1e6
    assert 0.99 < share_of(clutter) < 1.0


def test_the_share_of_clutter_rises_with_echoes_that_measure_a_strength() -> None:
    clutter = ClutterStatistics()
    for _ in range(3):
        count(clutter, [14.0, 16.0, 19.0])
    assert share_of(clutter) == pytest.approx(M.new_share * (0.1 + 9.0) / (M.many**2 + 9.0))


def test_the_next_one_goes_on_with_the_same_statistics_and_refuses_nonsense() -> None:
    one, other = ClutterStatistics(), ClutterStatistics()
    count(one, [14.0, 19.0])
    learn(one, table(2, clutter=0.9, nothing=0.1), np.ones(2, bool))
    other.load(one.save())
    np.testing.assert_array_equal(one.values, other.values)
    for place, value in ((ENDED_TRACKS, np.nan), (CLUTTER_TRACKS, -1.0), (CLUTTER_TRACKS, 9.0), (ECHOES, np.inf)):
        bad = one.save()
        bad[place] = value
        with pytest.raises(ValueError, match="clutter statistics"):
            ClutterStatistics().load(bad)
    with pytest.raises(ValueError, match=f"must be {LENGTH}"):
        ClutterStatistics().load(one.save()[:-1])


def test_a_new_track_needs_higher_odds_where_onsets_are_measured() -> None:
    """Odds of 200, where those of `confirm_existence`, 99, are enough, and of 200 and 400 where it takes 3.3 times."""
    history = np.zeros((len(History._fields), 1), np.int64)
    history[History._fields.index("echoes")] = LifeSettings().confirm_echoes
    hit, at, wide = np.ones(1, bool), np.zeros((3, 1)), np.ones((3, 1))
    for odds, onsets, state in ((200.0, 0.0, ACTIVE), (200.0, 3.0, TENTATIVE), (400.0, 3.0, ACTIVE)):
        tracks = table(visible=odds / (odds + 1.0), clutter=1.0 / (odds + 1.0), onsets=onsets)
        place = at, wide, at, np.ones(1), np.ones(1)
        assert states_after(history, tracks, (hit, hit, ~hit), place, 0).tolist() == [state]


def test_motion_is_for_an_object_and_never_against_one() -> None:
    """A ratio of the odds of rest before and now, up to a limit."""
    for at_rest, ratio in ((0.1, math.log(EVEN / 0.1)), (1e-9, M.motion_for), (0.9, 0.0)):
        judged = take_scan(table(visible=0.5, clutter=0.5), True, {}, at_rest=at_rest)
        assert judged.motion_ratio[0] == pytest.approx(ratio)


def reported(onset: float) -> float:
    return told_after(0.1, onset=onset, of_spots=3.0 * M.sharp)


def test_what_sets_in_sharply_is_reported_sooner_and_what_begins_slowly_later() -> None:
    assert reported(0.8 * M.sharp) + 0.3 < reported(0.0) < reported(2.0 * M.sharp) - 0.3


def test_what_sets_in_as_an_object_does_is_reported_sooner_and_a_crest_later() -> None:
    untold = told_after(0.1)
    assert told_after(0.1, front=0.99) + 0.3 < untold
    assert untold + 0.3 < told_after(0.1, front=0.02) < 10.0


def test_a_place_that_stays_takes_more_scans_in_a_crowd() -> None:
    assert told_after(0.1, rate_hz=10.0 * RATE_HZ) > told_after(0.1) + 0.2


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
