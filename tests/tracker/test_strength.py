"""How strong the echoes of nothing are: counted by range, and held against those of a body."""

import numpy as np
import pytest
from scipy.stats import logistic

from ods.base.arrays import Floats
from ods.tracker.association.strength import FEW, LASTING, MEMORY, MOST, POOLED, SPAN_DB, Strength, evidence
from ods.tracker.measurement.scan import Echoes, echoes_of
from ods.tracker.settings import TrackerSettings
from ods.tracker.state import StrengthState
from ods.tracker.tracker import Tracker
from tests.tracker.samples import RATE_HZ, SECTOR, scan

CALM_DB, BRIGHT_DB = 13.0, 20.0


def echoes(rows: list[tuple[float, float]]) -> Echoes:
    """Of (range, strength)."""
    table = np.array([(r, 0.0, 0.0, 1.0, 0.1, 0.01, 0.3, strength) for r, strength in rows])
    return echoes_of(table.reshape(-1, 8))[0]


def count(strength: Strength, rows: list[tuple[float, float]]) -> None:
    """An image of echoes that no confirmed object explains."""
    strength.count(echoes(rows), np.ones(len(rows), bool), SECTOR)


def test_echoes_are_counted_by_range_and_pooled() -> None:
    """Two rings, three images; against sums put together by hand."""
    strength, rng = Strength(), np.random.default_rng(3)
    near, far = rng.normal(14.0, 1.0, (3, 8)), rng.normal(18.0, 2.0, (3, 4))
    for image in range(3):
        count(strength, [(25.0, x) for x in near[image]] + [(75.0, x) for x in far[image]])
    fades = MEMORY ** np.array([2.0, 1.0, 0.0])
    values = np.concatenate([near.ravel(), far.ravel()])
    weights = np.concatenate([np.repeat(fades, 8), np.repeat(fades, 4)])
    for range_m, own, each in ((25.0, near, 8), (75.0, far, 4)):
        weight = np.concatenate([np.repeat(fades, each), POOLED * weights / weights.sum()])
        value = np.concatenate([own.ravel(), values])
        mean = np.average(value, weights=weight)
        told = strength.typical(np.array([range_m]), SECTOR).rows
        assert told.mean_db[0] == pytest.approx(mean)
        assert told.sigma_db[0] == pytest.approx(np.sqrt(np.average((value - mean) ** 2, weights=weight)))
        number = each * fades.sum()
        assert told.known[0] == pytest.approx(number / (number + FEW))
    assert strength.typical(np.array([45.0]), SECTOR).rows.known[0] == 0.0


@pytest.mark.parametrize(("excess", "count"), [(0.0, 1.0), (1.0, 4.0), (2.5, 30.0), (-1.0, 3.0)])
def test_evidence_is_the_ratio_of_an_even_density_and_a_logistic_one(excess: float, count: float) -> None:
    spread = np.sqrt(LASTING + (1.0 - LASTING) / count)
    law = logistic(scale=spread * np.sqrt(3.0) / np.pi)
    assert law.std() == pytest.approx(spread)
    expected = -0.8 * np.log(SPAN_DB * law.pdf(max(excess, 0.0)) / 1.2)
    assert evidence(excess, count, 1.2, 0.8) == pytest.approx(np.clip(expected, -MOST, MOST))


def test_an_image_has_as_many_from_the_first_one_on() -> None:
    strength = Strength()
    for _ in range(3):
        count(strength, [(25.0, 14.0), (50.0, 16.0), (75.0, 19.0)])
        assert strength.per_scan == pytest.approx(3.0)


def test_nothing_is_said_of_what_nobody_tells() -> None:
    strength = Strength()
    count(strength, [(50.0, 0.0)] * 5)
    told = strength.typical(np.array([50.0]), SECTOR).rows
    assert told.known[0] == 0.0
    assert evidence(0.0, 0.0, told.sigma_db[0], told.known[0]) == 0.0
    assert evidence(3.0, 1.0, told.sigma_db[0], told.known[0]) == 0.0


def test_what_confirmed_objects_explain_does_not_count() -> None:
    one, other = Strength(), Strength()
    table = echoes([(25.0, 14.0), (50.0, 16.0)])
    one.count(table, np.array([True, False]), SECTOR)
    count(other, [(25.0, 14.0)])
    assert one.state() == other.state()


def test_the_next_one_goes_on_with_the_same_counts_and_refuses_nonsense() -> None:
    one, other = Strength(), Strength()
    count(one, [(25.0, 14.0), (75.0, 19.0)])
    other.restore(one.state())
    where = np.array([25.0, 75.0])
    np.testing.assert_array_equal(one.typical(where, SECTOR).table, other.typical(where, SECTOR).table)
    rings = one.state().rings
    for bad in (rings[:-1], [np.nan, *rings[1:]], [-1.0, *rings[1:]]):
        with pytest.raises(ValueError, match=r"strength|reshape"):
            Strength().restore(StrengthState(bad, 1.0))
    with pytest.raises(ValueError, match="strength"):
        Strength().restore(StrengthState(rings, float("nan")))


def bed_with(body_db: float) -> Floats:
    """Return the times at which a body of that strength, at 60 m among lasting spots of CALM_DB, is told; s."""
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


def test_a_body_stronger_than_the_bottom_is_told_at_once_and_one_as_weak_later() -> None:
    bright, weak = bed_with(BRIGHT_DB), bed_with(CALM_DB)
    assert 0.0 < bright[0] < 0.6
    assert len(weak) == 0 or weak[0] > bright[0]
