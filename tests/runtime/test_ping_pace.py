"""How long a sonar may be silent, by hand-made times of pings."""

import pytest

from ods.base.clock import NS
from ods.runtime.ping_pace import PingPace


def pace_of(*times_s: float) -> PingPace:
    pace = PingPace()
    for t_s in times_s:
        pace.ping(round(t_s * NS))
    return pace


@pytest.mark.parametrize(
    ("period_s", "patience_s"), [(0.06, 1.0), (0.15, 1.0), (0.5, 1.5), (0.9, 2.7), (1.0, 3.0), (2.0, 3.0), (60.0, 3.0)]
)
def test_three_periods_but_a_second_at_least_and_three_at_most(period_s: float, patience_s: float) -> None:
    assert pace_of(*(k * period_s for k in range(20))).patience_s == pytest.approx(patience_s)


def test_nothing_is_known_before_two_pings() -> None:
    assert pace_of().patience_s == pace_of(7.0).patience_s == 1.0


@pytest.mark.parametrize("gap_s", [0.9, 5.0, 600.0])
def test_a_gap_is_no_pace(gap_s: float) -> None:
    assert pace_of(0.0, 0.15, 0.3, 0.3 + gap_s).patience_s == 1.0
    assert pace_of(0.0, gap_s, gap_s + 0.15).patience_s == 1.0


def test_another_range_is_followed_by_its_second_ping() -> None:
    assert pace_of(0.0, 0.15, 0.3, 0.45, 1.35, 2.25).patience_s == pytest.approx(2.7)
    assert pace_of(0.0, 0.9, 1.8, 2.7, 2.85, 3.0).patience_s == 1.0


def test_pings_out_of_order_tell_nothing() -> None:
    assert pace_of(0.0, 1.0, 2.0, 1.5, 2.0, 1.9).patience_s == pytest.approx(3.0)
