"""Rates, intervals and paired tests, against numbers from elsewhere."""

import pytest

from ods.missions.outcome import Ending, Outcome
from ods.missions.statistics import paired, rate_of, summary_of


def flown(arm: str, mission: int, ending: Ending = "success", **more: float) -> Outcome:
    values = {"clearance_m": 4.0, "path_m": 110.0, "time_s": 60.0, "not_valid_s": 6.0, **more}
    return Outcome(
        mission=mission,
        arm=arm,
        ending=ending,
        near_miss=False,
        evasions=2,
        evasions_of_nothing=1,
        listed=1,
        first_listed_m=40.0,
        time_to_collision_s=20.0 + mission,
        nearest_listed=True,
        warning="",
        **values,
    )


@pytest.mark.parametrize(
    ("count", "of", "low", "high"), [(0, 100, 0.0, 0.0370), (20, 1000, 0.0130, 0.0307), (5, 10, 0.2366, 0.7634)]
)
def test_intervals_are_wilson_s(count: int, of: int, low: float, high: float) -> None:
    """By the formula, (p + z^2/2n -+ z sqrt(pq/n + z^2/4n^2)) / (1 + z^2/n), by hand."""
    rate = rate_of(count, of)
    assert (rate.low, rate.high) == pytest.approx((low, high), abs=1e-4)


def test_mcnemar_looks_only_at_worlds_in_which_the_arms_differ() -> None:
    """1 and 9 of 10: 2 (C(10,0) + C(10,1)) / 2^10 = 0.0215."""
    first = [flown("none", k, "collision" if k < 12 else "success") for k in range(30)]
    second = [flown("ods", k, "collision" if 9 <= k < 12 or k == 20 else "success") for k in range(30)]
    (pair,) = paired(first + second, ("none", "ods"))
    assert (pair.only_first_collides, pair.only_second_collides) == (9, 1)
    assert pair.p == pytest.approx(22 / 1024)


def test_arms_that_never_differ_differ_by_chance() -> None:
    (pair,) = paired([flown("none", 0), flown("ods", 0)], ("none", "ods"))
    assert pair.p == 1.0


def test_ratios_are_of_missions_that_succeed() -> None:
    base = [flown("none", 0), flown("none", 1, "collision"), flown("none", 2)]
    best = [flown("all_knowing", 0, path_m=100.0, time_s=55.0), flown("all_knowing", 2)]
    own = [
        flown("ods", 0, time_s=66.0, path_m=120.0),
        flown("ods", 1, time_s=90.0),
        flown("ods", 2, "time-out", clearance_m=0.5, time_s=200.0),
    ]
    summary = summary_of("ods", base + own + best, 100.0)
    assert (summary.success.count, summary.time_out.count, summary.collision.count) == (2, 1, 0)
    assert summary.path_ratio == pytest.approx(1.15)
    assert summary.time_ratio == pytest.approx(1.1)
    assert (summary.path_over_best, summary.time_over_best) == pytest.approx((1.2, 1.2))
    assert summary.time_to_collision_s[2] == 21.0
    assert (summary.evasions, summary.evasions_of_nothing) == (2.0, 1.0)
    assert summary.not_valid_share == pytest.approx(18.0 / 356.0)
    assert summary.clearance_m[2] == 4.0
