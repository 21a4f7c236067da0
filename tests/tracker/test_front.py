"""How echoes set in by the chain's judgement: held against a body's, counted from what ended as spots."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from ods.tracker.association.front import (
    BODY,
    FEW,
    FIRST,
    FIRST_ECHOES,
    MEMORY,
    MOST,
    MOST_AGAINST,
    MOST_FOR,
    SURE,
    VARIANCE,
    Front,
    evidence,
    log_odds,
)
from ods.tracker.measurement.scan import LARGEST_PATCH_M, echoes_of
from ods.tracker.settings import TrackerSettings
from ods.tracker.state import FrontState, TrackerState
from ods.tracker.tracker import Tracker
from tests.tracker.samples import RATE_HZ, scan
from tests.tracker.spots import told_after


@pytest.mark.parametrize("of_spots", [-5.0, FIRST, 0.0, MOST])
@pytest.mark.parametrize(("mean", "echoes"), [(1.0, 1), (6.0, 3), (2.0, 10), (-3.0, 10), (9.0, 10)])
def test_evidence_is_the_ratio_of_two_normal_laws(mean: float, echoes: int, of_spots: float) -> None:
    sigma = np.sqrt(VARIANCE * (1.0 + FEW / echoes))
    expected = norm(BODY, sigma).logpdf(mean) - norm(of_spots, sigma).logpdf(mean)
    found = evidence(mean * echoes, float(echoes), of_spots)
    assert found == pytest.approx(np.clip(expected, -MOST_AGAINST, MOST_FOR), abs=1e-9)


def test_no_echo_says_nothing() -> None:
    assert evidence(0.0, 0.0, FIRST) == 0.0


@given(front=st.floats(0.0, 1.0))
def test_a_front_gives_odds_that_are_finite(front: float) -> None:
    assert abs(log_odds(front)) <= np.log((1.0 - SURE) / SURE) + 1e-9
    if SURE < front < 1.0 - SURE:
        assert 1.0 / (1.0 + np.exp(-log_odds(front))) == pytest.approx(front, rel=1e-6)


def test_what_spots_fronts_are_like_is_learned() -> None:
    front = Front()
    assert front.of_spots == pytest.approx(FIRST)
    front.learn(300.0, 100.0)
    front.learn(0.0, 0.0)
    expected = (300.0 * MEMORY + FIRST_ECHOES * FIRST) / (100.0 * MEMORY + FIRST_ECHOES)
    assert front.of_spots == pytest.approx(expected)
    other = Front()
    other.restore(front.state())
    assert other.of_spots == front.of_spots
    front.learn(9e6, 1e6)
    assert front.of_spots == MOST
    for bad in (FrontState(1.0, -1.0), FrontState(float("nan"), 2.0), FrontState(1.0, float("inf"))):
        with pytest.raises(ValueError, match="spots"):
            Front().restore(bad)


def test_what_sets_in_as_a_body_does_is_told_sooner_and_a_crest_later() -> None:
    """Beside spots of which nothing is told; a crest that stays in its place is told at last."""
    untold = told_after(0.1)
    assert told_after(0.1, front=0.99) + 0.3 < untold
    assert untold + 0.3 < told_after(0.1, front=0.02) < 10.0


def test_spots_that_end_teach_what_their_fronts_are_like() -> None:
    """A real bed may be unlike those that the network was learnt from."""
    rng, tracker = np.random.default_rng(6), Tracker(TrackerSettings())
    spots = [(rng.uniform(45.0, 75.0), rng.uniform(-0.7, 0.7)) for _ in range(20)]
    for k in range(round(10.0 * RATE_HZ)):
        lit = [(r + rng.normal(0.0, 0.8), b, 1.0) for r, b in spots if rng.random() < 0.3]
        image = scan(k / RATE_HZ, np.array([0.0, 0.0, 4.0]), 0.0, lit)
        image.echoes.rows.strength[:], image.echoes.rows.front[:] = 13.0, 0.8
        tracker.step(image)
    learned = tracker.state().front
    assert learned.echoes > 20.0
    assert learned.total / learned.echoes == pytest.approx(np.log(0.8 / 0.2))


def after_an_echo(radius: float, front: float) -> TrackerState:
    """Return what is known after nine echoes of a body of 1 m, and one of this radius, m, and front."""
    tracker = Tracker(TrackerSettings())
    for k in range(10):
        image = scan(k / RATE_HZ, np.zeros(3), 0.0, [(60.0, 0.1, radius if k == 9 else 1.0)])
        image.echoes.rows.strength[:], image.echoes.rows.front[:] = 13.0, front if k == 9 else 0.9
        tracker.step(image)
    return tracker.state()


def test_an_echo_that_is_joined_with_neighbours_tells_nothing_of_its_front() -> None:
    assert after_an_echo(6.0, 0.99) == after_an_echo(6.0, 0.0)
    assert after_an_echo(1.0, 0.99) != after_an_echo(1.0, 0.0)


@pytest.mark.parametrize(("radius", "tells"), [(LARGEST_PATCH_M, True), (LARGEST_PATCH_M + 0.1, False)])
def test_what_is_larger_than_a_patch_of_bottom_tells_neither_onset_nor_front(radius: float, tells: bool) -> None:
    """A long wall that stands aslant to the beams sets in slowly, and is no spot."""
    echoes, _ = echoes_of(np.array([[60.0, 0.1, 0.0, radius, 0.2, 0.01, 0.3, 25.0, 0.0, 0.0, 3.0, 0.02]]))
    assert (echoes.rows.onset[0] > 0.0, echoes.rows.front[0] > 0.0) == (tells, tells)
