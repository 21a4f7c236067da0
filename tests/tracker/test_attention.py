"""Focus of attention: what was not looked at in a ping says nothing about the objects there."""

from itertools import pairwise

import numpy as np
import pytest

from ods.tracker.association.hypotheses.clutter import Clutter
from ods.tracker.existence import lifecycle
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.samples import RANGE_MAX_M, RATE_HZ, SECTOR, course, echoes, run

NEAR_M = 20.0
BORDERS = (20.0, 40.0, 60.0, 80.0, RANGE_MAX_M)
TURNS = [((0.0, NEAR_M), ring) for ring in pairwise(BORDERS)]
STILL = np.zeros((3, 3))


def start(*north: float) -> np.ndarray:
    return np.array([(n, 2.0 * i, 4.0) for i, n in enumerate(north)])


@pytest.mark.parametrize("speed", [0.0, 1.5])
def test_objects_in_rings_looked_at_every_fourth_time_stay_confirmed(speed: float) -> None:
    """One near, one in a ring, one on the border of two; the vehicle stands or drives through the rings."""
    path = course(20.0, speed, start(45.0, 72.0, 80.0), STILL, np.ones(3))
    result = run(path, Tracker(TrackerSettings()), turns=TURNS)
    settled = round(5.0 * RATE_HZ)
    assert len(result.ids()) == 3
    for states in (result.states(i) for i in result.ids()):
        assert set(states[settled:]) == {lifecycle.ACTIVE}
    picture = result.snapshots[-1]
    for place in path.objects[-1]:
        assert result.nearest(-1, place)[1] < 0.5
    assert np.abs(picture.velocity[:2]).max() < 0.15


def test_an_object_that_is_gone_is_given_up_although_it_is_looked_at_seldom() -> None:
    path = course(60.0, 0.0, start(70.0), STILL[:1], np.ones(1))
    result = run(path, Tracker(TrackerSettings()), turns=TURNS, silent=(10.0, 60.0))
    assert len(result.snapshots[round(9.0 * RATE_HZ)].id) == 1
    assert len(result.ended) == 1


def test_confirmation_takes_as_many_looks_as_without_attention() -> None:
    path = course(10.0, 0.0, start(70.0), STILL[:1], np.ones(1))
    first = {}
    for name, turns in (("all", [()]), ("turns", TURNS)):
        snapshots = run(path, Tracker(TrackerSettings()), detection_probability=1.0, turns=turns).snapshots
        first[name] = next(k for k, picture in enumerate(snapshots) if len(picture.id))
    assert first["turns"] <= 4 * first["all"] + 4


def test_false_alarms_are_counted_per_look() -> None:
    """As many false alarms in each look at a range, however seldom it is looked at, are the same density."""
    everywhere, seldom = Clutter(1.0), Clutter(1.0)
    ranges = np.arange(5.0, 100.0, 10.0)
    for k in range(400):
        everywhere.count(echoes([(r, 0.0, 1.0) for r in ranges]), SECTOR, ())
        rings = TURNS[k % 4]
        seen = [(r, 0.0, 1.0) for r in ranges if any(a <= r < b for a, b in rings)]
        seldom.count(echoes(seen), SECTOR, rings)
    assert seldom.per_scan == pytest.approx(everywhere.per_scan, rel=0.02)
