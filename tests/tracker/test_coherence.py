"""A sonar at rest sees the same speckle again: such scans weigh little, and no crest becomes an object by it."""

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.tracker.existence.evidence import WEIGHT_AT_REST, Coherence
from ods.tracker.measurement.scan import Scan
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.samples import RATE_HZ, scan

HERE = np.zeros(3)


def seen(k: int, places: Floats, strength_db: Floats) -> Scan:
    """The k-th scan; places (n, 2) range, m, and bearing, rad."""
    image = scan(k / RATE_HZ, HERE, 0.0, [(r, b, 1.0) for r, b in places])
    image.echoes.rows.strength[:] = strength_db
    return image


@pytest.mark.parametrize(("range_m", "strength_db"), [(0.3, 0.1), (0.01, 3.0)])
def test_what_moves_or_is_of_another_strength_counts_whole(range_m: float, strength_db: float) -> None:
    rng, coherence = np.random.default_rng(1), Coherence()
    places = np.column_stack([rng.uniform(20.0, 80.0, 10), rng.uniform(-0.7, 0.7, 10)])
    for k in range(40):
        moved = places + rng.normal(0.0, 1.0, (10, 2)) * (range_m, 0.0005)
        assert coherence.weight(seen(k, moved, 13.0 + rng.normal(0.0, strength_db, 10)).echoes) == 1.0


def test_echoes_that_stay_weigh_little_though_some_come_and_go() -> None:
    rng, coherence = np.random.default_rng(1), Coherence()
    places = np.column_stack([rng.uniform(20.0, 80.0, 10), rng.uniform(-0.7, 0.7, 10)])
    found = []
    for k in range(40):
        there = rng.random(10) < 0.8
        measured = places[there] + rng.normal(0.0, 1.0, (there.sum(), 2)) * (0.01, 0.0005)
        found.append(coherence.weight(seen(k, measured, rng.normal(13.0, 0.1, there.sum())).echoes))
    assert found[0] == 1.0
    assert found[5:] == [WEIGHT_AT_REST] * 35
    assert coherence.weight(seen(40, np.zeros((0, 2)), np.zeros(0)).echoes) == WEIGHT_AT_REST


def false_after(strength_db: float) -> int:
    """Objects of a bottom whose places have an echo in two scans of three, of a strength that varies so much."""
    rng, tracker = np.random.default_rng(3), Tracker(TrackerSettings())
    places = np.column_stack([rng.uniform(40.0, 80.0, 20), rng.uniform(-0.6, 0.6, 20)])
    for k in range(round(30.0 * RATE_HZ)):
        lit = rng.random(20) < 0.67
        measured = places[lit] + rng.normal(0.0, 1.0, (lit.sum(), 2)) * (0.01, 0.0005)
        tracker.step(seen(k, measured, rng.normal(13.0, strength_db, lit.sum())))
    return len(tracker.snapshot())


def test_from_one_place_fewer_crests_become_objects() -> None:
    assert false_after(0.1) < false_after(3.0)
