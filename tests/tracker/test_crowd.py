"""Where highlights crowd, what stays and is seen again and again takes more to be told."""

import math

import pytest

from ods.tracker.association.crowd import MANY_A_SECOND, crowding
from ods.tracker.track import existence
from tests.tracker.samples import RATE_HZ
from tests.tracker.spots import told_after


def test_a_crowd_is_told_by_echoes_a_second() -> None:
    assert crowding(0.1 * MANY_A_SECOND, 0.1) == pytest.approx(0.5)
    assert crowding(10.0, 0.15) < 0.001, "a coarse sonar over rocks"
    assert crowding(40.0, 0.15) > 0.9, "three planes over ripples"
    assert crowding(0.0, 0.15) == crowding(10.0, 0.0) == 0.0, "nothing is known yet"


def test_in_a_crowd_it_says_less_that_a_place_is_seen_always() -> None:
    def seen_always(crowd: float) -> float:
        """Log-likelihood ratio of a body after 30 of 30."""
        ratio = 0.0
        for k in range(30):
            often = existence.how_often(float(k), float(k), 0.9, crowd)
            ratio += math.log(often.body / often.spot)
        return ratio

    assert seen_always(1.0) < seen_always(0.0) - 2.0


def test_a_place_that_stays_takes_more_images_in_a_crowd() -> None:
    assert told_after(0.1, rate_hz=10.0 * RATE_HZ) > told_after(0.1) + 0.5
