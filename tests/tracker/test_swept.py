"""A head that looks at one part of its sector after another: objects elsewhere are held, those passed by missed."""

import dataclasses
import math

import numpy as np
import pytest

from ods.base.clock import NS
from ods.messages import UnseenPart
from ods.tracker.existence import lifecycle
from ods.tracker.measurement.coverage.field_of_view import FieldOfView, exclude_not_swept
from ods.tracker.measurement.model import PredictedMeasurement
from ods.tracker.measurement.scan import not_swept_of, unseen_of
from ods.tracker.named import Named
from ods.tracker.output.validity import InputMonitor
from ods.tracker.settings import LifeSettings, TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.samples import HALF_FOV, SIGMA_BEARING, SIGMA_RANGE, scan

PART = math.radians(10.0)
PARTS = 9
EVERY_S = 1.0
SETTINGS = TrackerSettings(life=LifeSettings(confirm_existence=0.9))


class Head:
    """Parts of 10 degrees to and fro, one a second; a vehicle at rest."""

    def __init__(self, places: list[tuple[float, float, float]]) -> None:
        self.places = list(places)
        """Range, bearing, radius."""
        self.tracker, self.rng, self.second = Tracker(SETTINGS), np.random.default_rng(5), 0

    def sweep(self, count: int = 1) -> None:
        for _ in range(count * PARTS):
            turn, place = divmod(self.second, PARTS)
            part = place if turn % 2 == 0 else PARTS - 1 - place
            low = -HALF_FOV + part * PART
            rows = [
                (r + self.rng.normal(0.0, SIGMA_RANGE), b + self.rng.normal(0.0, SIGMA_BEARING), radius)
                for r, b, radius in self.places
                if low <= b < low + PART
            ]
            elsewhere = np.array([[-HALF_FOV - 0.1, low], [low + PART, HALF_FOV + 0.1]])
            seen = scan(EVERY_S * self.second, np.zeros(3), 0.0, rows)
            self.tracker.step(dataclasses.replace(seen, not_swept=elsewhere))
            self.second += 1

    def found(self) -> dict[tuple[int, int], int]:
        """Return the states of what is known, by range and bearing in degrees."""
        now = self.tracker.snapshot()
        north, east, _ = now.position
        rows = zip(np.hypot(north, east), np.degrees(np.arctan2(east, north)), now.state, strict=True)
        return {(round(r / 5) * 5, round(b / 5) * 5): int(state) for r, b, state in rows}


THINGS = [(40.0, math.radians(-20.0), 1.0), (5.0, math.radians(1.0), 1.5), (60.0, math.radians(30.0), 3.0)]


def test_objects_are_found_by_three_sweeps_and_held_while_the_head_looks_elsewhere() -> None:
    head = Head(THINGS)
    head.sweep(3)
    wanted = {(40, -20), (5, 0), (60, 30)}
    assert head.found().keys() == wanted
    for _ in range(4):
        head.sweep()
        assert head.found() == dict.fromkeys(wanted, lifecycle.ACTIVE)


@pytest.mark.parametrize("gone", range(3))
def test_one_that_is_gone_is_missed_when_the_head_passes_by_however_wide_it_looks_from_here(gone: int) -> None:
    head = Head(THINGS)
    head.sweep(4)
    assert len(head.found()) == 3
    place = head.places.pop(gone)
    head.sweep(10)
    left = head.found()
    key = (round(place[0] / 5) * 5, round(math.degrees(place[1]) / 5) * 5)
    assert left.get(key) != lifecycle.ACTIVE
    assert sum(state == lifecycle.ACTIVE for state in left.values()) == 2


def test_what_is_seen_follows_where_the_middle_may_be() -> None:
    names = PredictedMeasurement._fields
    table = np.zeros((len(names), 4))
    predicted = Named(PredictedMeasurement, table)
    predicted.rows.range_m[:] = predicted.rows.horizontal[:] = 20.0
    predicted.rows.bearing[:] = np.radians([5.0, 9.5, 20.0, 5.0])
    predicted.rows.across[:] = (20.0 * np.radians([0.5, 0.5, 0.5, 20.0])) ** 2
    flags, shares = np.zeros((3, 4), np.bool_), np.ones((2, 4))
    flags[0] = True
    seen = FieldOfView(flags[0], shares[0], flags[1], flags[2], shares[1])
    exclude_not_swept(seen, predicted, 0.0, np.radians([[-45.0, 0.0], [10.0, 45.0]]))
    assert seen.watched == pytest.approx([1.0, 0.84, 0.0, 0.0], abs=0.01)  # the normal distribution at one sigma
    assert seen.probability == pytest.approx([1.0, 0.84, 0.05, 0.226], abs=0.01)
    assert seen.unseen.tolist() == seen.skipped.tolist() == [False, False, True, True]


def test_not_swept_parts_are_no_blind_ones() -> None:
    parts = [UnseenPart(-1.0, 0.0, 0.0, 50.0, "not swept"), UnseenPart(0.0, 0.1, 0.0, 50.0, "no data")]
    assert unseen_of(parts).tolist() == [[0.0, 0.1, 0.0, 50.0]]
    assert not_swept_of(parts).tolist() == [[-1.0, 0.0]]


def test_a_list_is_valid_when_the_head_has_passed_by_each_object_four_times() -> None:
    fresh = InputMonitor(0, (), lambda _: "")
    reported = {}
    for second in range(50):
        fresh.ping(second * NS, 9.0)
        fresh.pose(second * NS)
        reported[second] = fresh.reasons(second * NS, pose_known=True)
    assert all(reported[second] for second in range(36))
    assert not any(reported[second] for second in range(36, 50))
