"""Figure 5: whatever the evidence, no path leads where it has no arrow."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ods.base.clock import NS
from ods.tracker.existence import lifecycle
from ods.tracker.existence.evidence import ExistenceTable
from ods.tracker.map.map_object import MapObject
from ods.tracker.settings import TrackerSettings
from ods.tracker.track.tracks import History
from ods.tracker.tracker import Tracker
from tests.tracker.judged import states_after
from tests.tracker.samples import scan

TRANSITIONS = {
    lifecycle.TENTATIVE: (lifecycle.ACTIVE, lifecycle.TERMINATED),
    lifecycle.ACTIVE: (lifecycle.STAND_BY,),
    lifecycle.STAND_BY: (lifecycle.ACTIVE, lifecycle.HIBERNATED, lifecycle.TERMINATED),
    lifecycle.HIBERNATED: (lifecycle.ACTIVE, lifecycle.TERMINATED),
}
"""The arrows of figure 5."""


@given(st.integers(0, 100_000))
def test_every_change_is_an_arrow_of_figure_5(seed: int) -> None:
    rng, n, now = np.random.default_rng(seed), 200, 60 * NS
    last = now - np.round(rng.exponential(5.0, n) * NS).astype(np.int64)
    history = History(*np.zeros((len(History._fields), n), np.int64))._replace(
        state=rng.integers(0, 4, n),
        echoes=rng.integers(1, 10, n),
        born=last - rng.integers(0, 20 * NS, n),
        last=last,
        unwatched=np.round((now - last) * rng.random(n)).astype(np.int64),
    )
    hit, inside, skipped = rng.random((3, n)) < 0.5
    estimate = rng.normal(0.0, 5.0, (3, n)), rng.exponential(9.0, (3, n)), rng.exponential(1.0, (3, n))
    existence = np.zeros((len(ExistenceTable._fields), n))
    existence[:4], existence[4] = rng.dirichlet(np.full(4, 0.3), n).T, rng.random(n)
    after = states_after(
        np.stack(history), existence, (hit, inside, skipped & inside), (*estimate, *rng.random((2, n))), now
    )
    for old, new in zip(history.state.tolist(), after.tolist(), strict=True):
        assert old == new or new in TRANSITIONS[old]


@pytest.mark.parametrize(
    ("old", "new"), [(lifecycle.STAND_BY, lifecycle.TENTATIVE), (lifecycle.HIBERNATED, lifecycle.ACTIVE)]
)
def test_an_object_beside_one_that_was_recalled_from_the_map_is_confirmed(old: int, new: int) -> None:
    """Recalled a second ago and not seen since, it was not seen after the new one began, as one in stand-by was."""
    now = 60 * NS
    history = History(*np.zeros((len(History._fields), 2), np.int64))._replace(
        state=np.array([old, lifecycle.TENTATIVE]),
        echoes=np.array([20, 20]),
        born=np.array([0, now - 2 * NS]),
        last=np.array([now - NS, now]),
    )
    existence = np.zeros((len(ExistenceTable._fields), 2))
    existence[0] = 1.0
    hit = np.array([False, True])
    position, variance = np.array([[0.0, 15.0], [0.0, 0.0], [0.0, 0.0]]), np.ones((3, 2))
    estimate = position, variance, np.zeros((3, 2)), np.array([10.0, 10.0]), np.ones(2)
    seen = hit, np.ones(2, np.bool_), np.zeros(2, np.bool_)
    assert states_after(np.stack(history), existence, seen, estimate, now).tolist() == [old, new]


@settings(max_examples=15)
@given(
    st.lists(
        st.tuples(st.sampled_from(["hit", "miss", "away", "drop-out"]), st.integers(1, 30)), min_size=2, max_size=8
    )
)
def test_an_object_only_walks_along_the_arrows(plan: list[tuple[str, int]]) -> None:
    """One object at (50, 0): seen, missed, out of view (the vehicle looks back), or the whole image is no good."""
    tracker = Tracker(TrackerSettings())
    rng = np.random.default_rng(0)
    t, states = 0.0, []
    for what, count in [("hit", 5), *plan]:
        for _ in range(count):
            t += float(rng.exponential(0.5))
            rows = [(50.0 + rng.normal(0, 0.1), rng.normal(0, 0.008), 1.0)] if what == "hit" else []
            tracker.step(scan(t, np.zeros(3), np.pi if what == "away" else 0.0, rows, usable=what != "drop-out"))
            picture = tracker.snapshot()
            states.append(dict(zip(picture.id.tolist(), picture.state.tolist(), strict=True)))
    for before, after in pairwise(states):
        for object_id, state in after.items():
            old = before.get(object_id, lifecycle.TENTATIVE)
            assert state == old or state in TRANSITIONS[old]
        for object_id in before.keys() - after.keys():
            assert lifecycle.TERMINATED in TRANSITIONS[before[object_id]]
    ids = [i for state in states for i in state]
    assert all(i < tracker.next_id for i in ids)


@pytest.mark.parametrize("images", [1, 7])
def test_objects_outlive_a_drop_out_of_a_second(images: int) -> None:
    """All echoes stay away at once; after it the same objects are reported."""
    tracker, rows = Tracker(TrackerSettings()), [(30.0 + 10 * i, 0.2 * i - 0.4, 1.0) for i in range(4)]
    for k in range(30 + images):
        tracker.step(scan(k / 7, np.zeros(3), 0.0, rows if k < 20 or k >= 20 + images else []))
        if k >= 3:
            assert sorted(tracker.snapshot().id) == [1, 2, 3, 4]


def test_a_hibernated_object_that_is_gone_is_terminated() -> None:
    rock = MapObject(7, (50.0, 0.0, 0.0), (0.1, 0.1, 0.1), 1.0, 0.1, 0.99, 100, 1, 2, 3)
    tracker = Tracker(TrackerSettings(), [rock], first_id=8)
    assert tracker.snapshot().id.tolist() == [7]
    ended: list[int] = []
    for k in range(600):
        outcome = tracker.step(scan(k / 7, np.zeros(3), 0.0, []))
        ended += [] if outcome.ended is None else outcome.ended.id.tolist()
    assert ended == [7]
    assert len(tracker.snapshot()) == 0


def test_older_and_simultaneous_scans() -> None:
    tracker = Tracker(TrackerSettings())
    rows = [(50.0, 0.0, 1.0)]
    assert tracker.step(scan(1.0, np.zeros(3), 0.0, rows)).taken
    assert tracker.step(scan(1.0, np.zeros(3), 0.0, rows)).taken  # dt = 0: another look at the same instant
    assert not tracker.step(scan(0.9, np.zeros(3), 0.0, rows)).taken
    assert tracker.step(scan(1e5, np.zeros(3), 0.0, rows)).taken  # a gap of a day
    assert np.isfinite(tracker.snapshot().position).all()
