"""How sharply echoes set in: held against a body's, counted from what ended as spots."""

import numpy as np
import pytest
from scipy.stats import betabinom

from ods.tracker.association.onset import (
    BODY_SHARP,
    BODY_SLOW,
    DEARER,
    ENOUGH,
    FIRST,
    FIRST_ECHOES,
    MEMORY,
    MOST,
    MOST_AGAINST,
    MOST_FOR,
    SHARP,
    SPOT_LOOKS,
    Onset,
    evidence,
)
from ods.tracker.settings import TrackerSettings
from ods.tracker.state import OnsetState, TrackerState
from ods.tracker.track.doubt import Doubt, proof
from ods.tracker.tracker import Tracker
from tests.tracker.samples import RATE_HZ, scan
from tests.tracker.spots import told_after


@pytest.mark.parametrize("of_spots", [0.02, FIRST, 0.5, MOST])
@pytest.mark.parametrize(("sharp", "echoes"), [(0, 1), (1, 1), (2, 5), (9, 12), (0, 3), (1, 8), (0, 40)])
def test_evidence_is_the_ratio_of_two_beta_binomial_laws(sharp: int, echoes: int, of_spots: float) -> None:
    body = betabinom(echoes, BODY_SHARP, BODY_SLOW).logpmf(sharp)
    spot = betabinom(echoes, SPOT_LOOKS * of_spots, SPOT_LOOKS * (1.0 - of_spots)).logpmf(sharp)
    expected = np.clip(body - spot, -MOST_AGAINST if echoes >= ENOUGH else 0.0, MOST_FOR)
    assert evidence(float(sharp), float(echoes), of_spots) == pytest.approx(expected, abs=1e-9)


def test_no_echo_says_nothing() -> None:
    assert evidence(0.0, 0.0, FIRST) == pytest.approx(0.0, abs=1e-12)


def test_what_spots_echoes_are_like_is_learned() -> None:
    onset = Onset()
    assert onset.of_spots == pytest.approx(FIRST)
    onset.learn(60.0, 100.0)
    onset.learn(0.0, 0.0)
    assert onset.of_spots == pytest.approx((60.0 * MEMORY + FIRST_ECHOES * FIRST) / (100.0 * MEMORY + FIRST_ECHOES))
    other = Onset()
    other.restore(onset.state())
    assert other.of_spots == onset.of_spots
    onset.learn(1e6, 1e6)
    assert onset.of_spots == MOST
    for bad in (OnsetState(2.0, 1.0), OnsetState(-1.0, 2.0), OnsetState(1.0, float("nan"))):
        with pytest.raises(ValueError, match="spots"):
            Onset().restore(bad)


def told(onset: float) -> float:
    return told_after(0.1, onset=onset, of_spots=3.0 * SHARP)


def test_what_sets_in_sharply_is_told_sooner_and_what_begins_slowly_later() -> None:
    assert told(0.8 * SHARP) + 0.3 < told(0.0) < told(2.0 * SHARP) - 0.3


def after_an_echo(radius: float, onset: float) -> TrackerState:
    """Return what is known after nine sharp echoes of a body of 1 m and one of this radius, m, and onset."""
    tracker = Tracker(TrackerSettings())
    for k in range(10):
        image = scan(k / RATE_HZ, np.zeros(3), 0.0, [(60.0, 0.1, radius if k == 9 else 1.0)])
        image.echoes.rows.strength[:], image.echoes.rows.onset[:] = 13.0, onset if k == 9 else 0.8 * SHARP
        tracker.step(image)
    return tracker.state()


def test_an_echo_that_is_joined_with_neighbours_tells_nothing_of_its_onset() -> None:
    assert after_an_echo(6.0, 2.0 * SHARP) == after_an_echo(6.0, 0.0)
    assert after_an_echo(1.0, 2.0 * SHARP) != after_an_echo(1.0, 0.0)


def test_what_is_new_needs_higher_odds_where_its_echoes_tell_their_onset() -> None:
    table = np.zeros((len(Doubt._fields), 2))
    d = Doubt(*table)
    d.visible[:], d.silent[:], d.nothing[:], d.spot[:] = 0.97, 0.02, 0.006, 0.004
    d.set_in[1] = 3.0
    assert proof(table, 0) == pytest.approx(0.99)
    assert proof(table, 1) / (1.0 - proof(table, 1)) == pytest.approx(99.0 / DEARER)
