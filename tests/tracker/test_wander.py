"""How far echoes wander along the range: held against a body's, counted from what ended as spots."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import invgamma

from ods.base.arrays import Floats
from ods.tracker.association.wander import (
    BODY_SHARE,
    FIRST_ECHOES,
    FIRST_M,
    MEMORY,
    MOST_AGAINST,
    MOST_FOR,
    SURE,
    Wander,
    evidence,
)
from ods.tracker.state import WanderState
from tests.tracker.spots import told_after


def density(off_m: Floats, mean_square: float) -> float:
    """Of echoes normal about the place, their variance not known: integrated numerically."""
    law = invgamma(0.5 * SURE, scale=0.5 * SURE * mean_square)

    def given(log_variance: float) -> float:
        variance = np.exp(log_variance)
        likelihood = np.exp(-0.5 * np.sum(off_m**2) / variance) / variance ** (0.5 * len(off_m))
        return float(likelihood * law.pdf(variance) * variance)

    return quad(given, np.log(1e-4), np.log(1e3), limit=500)[0]


@pytest.mark.parametrize("sigma_m", [0.3, 0.5, 0.9])
@pytest.mark.parametrize("echoes", [1, 4, 12])
def test_evidence_is_the_ratio_of_two_densities_of_unknown_variance(sigma_m: float, echoes: int) -> None:
    off = np.random.default_rng(echoes).normal(0.0, sigma_m, echoes)
    expected = np.log(density(off, (BODY_SHARE * 0.85) ** 2) / density(off, 0.85**2))
    found = evidence(float(np.sum(off**2)), float(echoes), 0.85**2, 0.0)
    assert found == pytest.approx(np.clip(expected, -MOST_AGAINST, MOST_FOR), rel=1e-4)


def test_no_echo_says_nothing() -> None:
    assert evidence(0.0, 0.0, 0.7, 0.0) == pytest.approx(0.0, abs=1e-12)


def test_what_spots_wander_is_learned() -> None:
    wander = Wander()
    assert wander.of_spots_m2 == pytest.approx(FIRST_M**2)
    wander.learn(20.0, 200.0)
    wander.learn(0.0, 0.0)
    expected = (MEMORY * 20.0 + FIRST_ECHOES * FIRST_M**2) / (MEMORY * 200.0 + FIRST_ECHOES)
    assert wander.of_spots_m2 == pytest.approx(expected)
    other = Wander()
    other.restore(wander.state())
    assert other.of_spots_m2 == wander.of_spots_m2
    for bad in (WanderState(-1.0, 2.0), WanderState(1.0, float("nan"))):
        with pytest.raises(ValueError, match="wander"):
            Wander().restore(bad)


def test_a_place_that_stays_is_told_before_one_that_wanders() -> None:
    assert told_after(0.1) + 0.3 < told_after(0.7)


def test_echoes_that_the_fans_edge_cuts_off_say_nothing_of_how_far_a_body_wanders() -> None:
    """They stay as they are no sooner told of than they are when they slide along the body."""
    assert told_after(0.1) + 0.3 < told_after(0.1, cut=True)
