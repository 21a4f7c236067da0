"""Objects in parts of the sector that the sonar could not show are unseen, not missed: they are carried on."""

import dataclasses
import math

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.messages import UnseenPart
from ods.tracker.existence import lifecycle
from ods.tracker.measurement.scan import unseen_of
from ods.tracker.output.validity import InputMonitor
from ods.tracker.settings import LifeSettings, TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.samples import HALF_FOV, RATE_HZ, SIGMA_BEARING, SIGMA_RANGE, scan

PORT_HALF = np.array([[-HALF_FOV - 0.01, 0.0, 0.0, 110.0]])
FAR_HALF = np.array([[-HALF_FOV - 0.01, HALF_FOV + 0.01, 50.0, 110.0]])


class Sea:
    """A vehicle that goes north, and objects around it; every echo is seen but those in `unseen`."""

    def __init__(self, places: list[tuple[float, float]], speed: float = 0.3, velocity: float = 0.0) -> None:
        self.tracker, self.rng = Tracker(TrackerSettings()), np.random.default_rng(12)
        self.places, self.speed, self.velocity, self.k = np.array(places), speed, velocity, 0

    def truth(self) -> Floats:
        """Return the (n, 2) north and east of the objects now."""
        return np.asarray(self.places + np.array([0.0, self.velocity * self.k / RATE_HZ]))

    def run(self, seconds: float, unseen: Floats) -> None:
        for _ in range(round(seconds * RATE_HZ)):
            t_s = self.k / RATE_HZ
            rows = []
            for north, east in self.truth() - (self.speed * t_s, 0.0):
                distance, bearing = math.hypot(north, east), math.atan2(east, north)
                hidden = any(a < bearing < b and near < distance < far for a, b, near, far in unseen)
                if not hidden and abs(bearing) < HALF_FOV:
                    noise = self.rng.normal(0.0, (SIGMA_RANGE, SIGMA_BEARING))
                    rows.append((distance + noise[0], bearing + noise[1], 1.0))
            empty = scan(t_s, np.array([self.speed * t_s, 0.0, 4.0]), 0.0, rows)
            self.tracker.step(dataclasses.replace(empty, unseen=unseen))
            self.k += 1

    def states(self) -> dict[int, int]:
        now = self.tracker.snapshot()
        return dict(zip(now.id.tolist(), now.state.tolist(), strict=True))


NOTHING = np.empty((0, 4))
STATIC = [(60.0, -30.0), (80.0, -10.0), (70.0, 20.0), (85.0, 30.0)]


@pytest.mark.parametrize("dead", [PORT_HALF, FAR_HALF])
def test_objects_in_a_blind_part_keep_their_ids_and_their_places_are_as_sure_as_claimed(dead: Floats) -> None:
    sea = Sea(STATIC)
    sea.run(10.0, NOTHING)
    before = sea.states()
    assert len(before) == 4
    sea.run(60.0, dead)
    assert sea.states() == before == dict.fromkeys(before, lifecycle.ACTIVE)
    now = sea.tracker.snapshot()
    truth = sea.truth()
    error = now.position[:2].T - truth[np.argmin(np.hypot(*(now.position[:2, :, None] - truth.T[:, None, :])), axis=1)]
    assert (np.abs(error) < 3.0 * now.sigma_position[:2].T).all()
    hidden = now.unseen_s > 55.0
    assert 0 < np.count_nonzero(hidden) < 4
    assert (now.unseen_s[~hidden] == 0.0).all()
    sea.run(5.0, NOTHING)
    assert sea.states() == before
    assert (sea.tracker.snapshot().unseen_s == 0.0).all()


def test_without_word_of_the_blind_part_the_same_objects_are_given_up() -> None:
    """What the word is worth: as it was."""
    sea = Sea(STATIC)
    sea.run(10.0, NOTHING)
    for _ in range(round(20.0 * RATE_HZ)):
        t_s = sea.k / RATE_HZ
        sea.tracker.step(scan(t_s, np.array([0.3 * t_s, 0.0, 4.0]), 0.0, []))
        sea.k += 1
    assert lifecycle.ACTIVE not in sea.states().values()


def test_moving_object_is_given_up_when_its_place_is_not_known_any_more() -> None:
    sea = Sea([(60.0, -45.0), (70.0, 10.0)], velocity=0.4)
    sea.run(10.0, NOTHING)
    before = sea.states()
    assert len(before) == 2
    sea.run(5.0, PORT_HALF)
    assert sea.states() == before
    lost_sigma_m = LifeSettings().lost_sigma_m
    for _ in range(120):
        sea.run(1.0, np.array([[-HALF_FOV - 0.01, 2.0, 0.0, 110.0]]))
        sigma = sea.tracker.snapshot().sigma_position[:2].max(axis=0, initial=0.0)
        if len(sea.states()) < 2:
            break
        assert (sigma < lost_sigma_m + 1.0).all()
    else:
        pytest.fail("kept for two minutes though its place is not known")


def test_object_half_hidden_is_not_missed_and_one_beside_the_blind_part_is() -> None:
    for edge, state in ((0.0, lifecycle.ACTIVE), (-0.1, lifecycle.STAND_BY)):
        sea = Sea([(60.0, 0.0)], speed=0.0)
        sea.run(10.0, NOTHING)
        sea.places = np.array([[60.0, 500.0]])  # it is gone
        sea.run(5.0, np.array([[-HALF_FOV - 0.01, edge, 0.0, 110.0]]))
        assert list(sea.states().values()) == [state]


def test_parts_that_are_none_are_left_out() -> None:
    good = UnseenPart(-0.1, 0.1, 5.0, 9.0, "no data")
    bad = [UnseenPart(math.nan, 0.1, 5.0, 9.0, "no data"), UnseenPart(0.0, 0.1, 5.0, math.inf, "saturated")]
    assert unseen_of([bad[0], good, bad[1]]).tolist() == [[-0.1, 0.1, 5.0, 9.0]]


def reasons_of(shares: list[float]) -> list[list[str]]:
    """Return the reasons after each ping, ten a second, that did not show a share of the image."""
    monitor, found = InputMonitor(0, [], str), []
    for k, share in enumerate(shares):
        t_ns = k * 10**8
        monitor.pose(t_ns)
        monitor.ping(t_ns)
        monitor.observed(t_ns, share, "why" if share else "")
        found.append([reason for reason in monitor.reasons(t_ns, pose_known=True) if "just started" not in reason])
    return found


def test_list_is_not_valid_when_most_is_unseen_for_half_a_second_and_at_once_when_it_is_seen_again() -> None:
    found = reasons_of([0.0] * 20 + [0.6] * 20 + [0.0] * 5)
    assert found[:25] == [[]] * 25
    assert found[25] == ["why, for 0.6 s"]
    assert found[39] == ["why, for 2.0 s"]
    assert found[40:] == [[]] * 5
    assert reasons_of([0.0] * 12 + [1.0] * 3 + [0.0] * 12 + [0.4] * 30) == [[]] * 57
    assert reasons_of([1.0] * 10)[-1] == ["why, for 0.9 s"]
