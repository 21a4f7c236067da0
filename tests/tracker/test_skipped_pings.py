"""Pings that nobody looked at: they missed nothing."""

import dataclasses

import numpy as np

from ods.tracker.existence import lifecycle
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.samples import RATE_HZ, scan

SEEN = 20
SILENT_S = 4.0


def state_after_silence(every: int, skipped_pings: int) -> int:
    """Return the state of an object seen in SEEN pings, after SILENT_S of which every so many pings show nothing."""
    tracker, vehicle = Tracker(TrackerSettings()), np.array([0.0, 0.0, 4.0])
    for k in range(SEEN):
        tracker.step(scan(k / RATE_HZ, vehicle, 0.0, [(40.0, 0.0, 1.0)]))
    for k in range(SEEN - 1 + every, SEEN + round(SILENT_S * RATE_HZ), every):
        empty = scan(k / RATE_HZ, vehicle, 0.0, [])
        tracker.step(dataclasses.replace(empty, skipped_pings=skipped_pings))
    (state,) = tracker.snapshot().state.tolist()
    return int(state)


def test_an_object_is_silent_only_in_images_that_were_looked_at() -> None:
    assert state_after_silence(every=14, skipped_pings=13) == lifecycle.ACTIVE
    assert state_after_silence(every=14, skipped_pings=0) == lifecycle.STAND_BY
    assert state_after_silence(every=1, skipped_pings=0) == lifecycle.STAND_BY


def test_a_drop_out_makes_nothing_silent() -> None:
    tracker, vehicle = Tracker(TrackerSettings()), np.array([0.0, 0.0, 4.0])
    for k in range(SEEN):
        tracker.step(scan(k / RATE_HZ, vehicle, 0.0, [(40.0, 0.0, 1.0)]))
    after = round(SILENT_S * RATE_HZ)
    for k in range(SEEN, SEEN + after):
        tracker.step(scan(k / RATE_HZ, vehicle, 0.0, [], usable=False))
    tracker.step(scan((SEEN + after) / RATE_HZ, vehicle, 0.0, []))
    assert tracker.snapshot().state.tolist() == [lifecycle.ACTIVE]
