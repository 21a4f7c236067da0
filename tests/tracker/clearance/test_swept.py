"""A sector that is shown part after part: what is told to be empty could not have been reached from unknown water."""

import math

import numpy as np
import pytest

from ods.base.clock import NS
from ods.messages import Clearance, Detection, Detections, ObstacleList, PoseAt, Sector, UnseenPart
from ods.tracker.clearance.clearance import ClearanceKeeper
from ods.tracker.settings import ClearanceSettings

RANGE_M = 40.0
FASTEST = 0.5
SETTINGS = ClearanceSettings(sectors=72, half_height_m=0.3, fastest_m_s=FASTEST, fastest_vertical_m_s=0.1)
SECTOR = Sector(1.0, RANGE_M, -math.pi / 2, math.pi / 2, math.radians(12.5))
POSE = PoseAt((0.0, 0.0, 5.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 3, (0.0,) * 3, (0.0,) * 3)
PART = math.radians(18.0)
BEAMS = 10
"""Of a part."""
ROCK = Detection(
    range_m=20.5, bearing_rad=0.3, radius_m=0.5, peak=5.0, mean=3.0, snr_db=14.0, cells=9, range_extent_m=1.0,
    bearing_extent_rad=0.06, sigma_range_m=0.1, sigma_bearing_rad=0.01, sigma_radius_m=0.2, near_m=20.0,
    sigma_near_m=0.1,
)  # fmt: skip


class Intruders:
    """Things as fast as can be that go any way, until a beam hits them."""

    def __init__(self, count: int = 40_000) -> None:
        self.rng = np.random.default_rng(7)
        self.place = self.rng.uniform(-RANGE_M - 10.0, RANGE_M + 10.0, (count, 2))
        self.course = self.rng.uniform(0.0, 2.0 * math.pi, count)

    def beam(self, low: float, high: float, seconds: float, *, rock: bool) -> None:
        """Let them go on, and take out those in the beam."""
        turns = self.rng.random(len(self.course)) < 0.02
        self.course[turns] = self.rng.uniform(0.0, 2.0 * math.pi, np.count_nonzero(turns))
        self.place += FASTEST * seconds * np.column_stack([np.cos(self.course), np.sin(self.course)])
        away, bearing = np.hypot(*self.place.T), np.arctan2(self.place[:, 1], self.place[:, 0])
        seen = (bearing >= low) & (bearing < high) & (away > 1.0) & (away < RANGE_M)
        if rock:
            seen &= ~((np.abs(bearing - ROCK.bearing_rad) < 0.03) & (away > ROCK.near_m))
        self.place, self.course = self.place[~seen], self.course[~seen]

    def in_water(self, told: Clearance) -> int:
        """Return how many are in water that is told to be empty."""
        away, sector = np.hypot(*self.place.T), np.arctan2(self.place[:, 1], self.place[:, 0]) % (2.0 * math.pi)
        k = (sector / (2.0 * math.pi / 72)).astype(int) % 72
        inside = (away > np.array(told.clear_from_m)[k]) & (away < np.array(told.clear_to_m)[k])
        return int(np.count_nonzero(inside))


class Sweeps:
    """A vehicle at rest, a part of the sector a second, beam by beam, to and fro."""

    def __init__(self, turn_s: float = 10.0) -> None:
        self.keeper, self.number, self.turn_s, self.intruders = ClearanceKeeper(SETTINGS), 0, turn_s, Intruders()

    def part(self, *, rock: bool = False) -> Clearance:
        k, (turn, place) = self.number, divmod(self.number, 10)
        low = -math.pi / 2 + PART * (place if turn % 2 == 0 else 9 - place)
        high = low + PART
        for beam in range(BEAMS) if turn % 2 == 0 else reversed(range(BEAMS)):
            left = low + PART * beam / BEAMS
            overlap = 0.5 * PART / BEAMS  # as beams of 2 degrees have in steps of 1
            self.intruders.beam(left - overlap, left + PART / BEAMS + overlap, 1.0 / BEAMS, rock=rock)
        gaps = [(-math.pi / 2, low), (high, math.pi / 2)]
        unseen = [UnseenPart(*gap, 1.0, RANGE_M, "not swept") for gap in gaps if gap[1] - gap[0] > 1e-6]
        echoes = [ROCK] if rock and low <= ROCK.bearing_rad < high else []
        t_ns = k * NS
        told = ObstacleList(k, k, t_ns, t_ns, t_ns, True, [], [], pose=POSE, head=POSE, made_ns=t_ns)
        shown = Detections(k, k, t_ns, t_ns, t_ns, 1500.0, SECTOR, echoes, unseen=unseen, turn_s=self.turn_s)
        self.number += 1
        return self.keeper.after(told, shown)


@pytest.mark.parametrize("rock", [False, True])
def test_nothing_could_have_come_to_what_is_told_to_be_empty(rock: bool) -> None:
    sweeps, most_m = Sweeps(), 0.0
    for _ in range(45):
        made = sweeps.part(rock=rock)
        assert not sweeps.intruders.in_water(made)
        most_m = max(most_m, sum(made.clear_to_m) - sum(made.clear_from_m))
    assert most_m > 300.0


def test_parts_that_were_swept_before_are_held_and_an_echo_is_never_in_empty_water() -> None:
    sweeps = Sweeps()
    for _ in range(30):
        made = sweeps.part()
    assert made.clear_to_m[0] > 20.0  # it is five seconds since the head looked there
    for _ in range(10):
        made = sweeps.part(rock=True)
    k = round(math.degrees(ROCK.bearing_rad) / 5.0 - 0.5)
    assert not made.clear_from_m[k] - 1.0 < ROCK.near_m < made.clear_to_m[k] + 1.0


def test_pings_that_show_all_at_once_are_no_parts_of_one_another() -> None:
    sweeps = Sweeps(turn_s=0.0)
    for _ in range(30):
        made = sweeps.part()
    assert made.clear_to_m[0] < 20.0
