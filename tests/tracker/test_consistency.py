"""Errors are as large as told where the sonar cannot see: elevation, wide beams, biased poses; all by simulated echoes.

Few runs with fixed seeds of what `benchmarks.tracker.consistency` measures: echoes from eq. 1 without the project's
geometry. A consistent tracker has a mean of 2; of 36 objects 95 % of the means lie within 0.6 of it. Before what pings
share was kept, they were 9 to 20,000.
"""

import numpy as np
import pytest

from benchmarks.tracker.consistency import Case, one_run
from ods.tracker.observer.registry import OBSERVERS

pytestmark = pytest.mark.slow

RUNS = 6
UNSEEN = (
    Case("level", 50.0),
    Case("pitched", 90.0, pitch_deg=10.0),
    Case("steeply pitched", 50.0, pitch_deg=20.0),
    Case("level and under way", 50.0, vehicle_speed=1.5),
    Case("pitched and under way", 50.0, pitch_deg=20.0, vehicle_speed=1.5),
    Case("pitching", 50.0, swing_deg=10.0),
    Case("rolled", 90.0, roll_deg=20.0),
    Case("all of it", 70.0, pitch_deg=10.0, pose_m=0.3, yaw_deg=1.0, vehicle_speed=1.5),
)
ROLLED = Case("rolled, wide beam", 100.0, sigma_bearing_deg=3.0, roll_deg=10.0)
TILTED = (
    Case("tilted", 50.0, tilt_deg=2.0),
    Case("tilted, under way", 50.0, tilt_deg=2.0, vehicle_speed=1.5),
)
ON_AXIS = (
    Case("wide beam", 100.0, 0.1, sigma_bearing_deg=3.0),
    Case("wide beam, moving", 80.0, 0.1, sigma_bearing_deg=2.0, object_speed=0.5),
    Case("biased pose", 60.0, 0.1, pose_m=0.3, yaw_deg=1.0, vehicle_speed=1.5),
    Case("slow", 50.0, 0.1, object_speed=0.1),
)
MOVING = tuple(Case(f"pitch {pitch}", 60.0, pitch_deg=pitch, object_speed=0.5) for pitch in (10.0, 20.0))
CLIMBING = Case("climbs", 60.0, 0.5, object_speed=0.5, object_climb=0.2, pitch_deg=20.0)
CREEPING = ((0.02, 15.0), (0.05, 9.0), (0.1, 6.0))
"""Speeds, m/s, and when the lag of the average is largest, s."""


def errors(case: Case, observer: str) -> tuple[float, float]:
    """Return the mean NEES from 3 s on, and the share of objects that are taken to move at the end."""
    found = [one_run(case, observer, np.random.default_rng([7, run])) for run in range(RUNS)]
    nees = np.concatenate([one.nees[1:] for one in found], axis=1)
    moving = np.concatenate([one.moving[-1] for one in found])
    assert np.isfinite(nees).mean() > 0.8
    return float(np.nanmean(nees)), float(np.nanmean(moving))


@pytest.mark.parametrize("observer", OBSERVERS)
def test_elevation_is_carried_as_uncertainty(observer: str) -> None:
    for case in UNSEEN:
        nees, moving = errors(case, observer)
        assert 1.3 < nees < 2.8, case.name
        assert moving < 0.1, case.name


@pytest.mark.parametrize("observer", OBSERVERS)
def test_noise_before_a_rolled_fan_tells_nothing_of_the_height(observer: str) -> None:
    """Each echo moved the line of sight, which was taken for another look: the means were 6.7 to 8.7."""
    nees, _ = errors(ROLLED, observer)
    assert 1.3 < nees < 2.8


@pytest.mark.parametrize("observer", OBSERVERS)
def test_a_vehicle_tilted_otherwise_than_it_tells(observer: str) -> None:
    """What lies higher or lower is turned aside, in all pings alike: the means of the first were 6.0 to 9.8."""
    for case in TILTED:
        nees, _ = errors(case, observer)
        assert 0.7 < nees < 2.2, case.name


@pytest.mark.parametrize("observer", OBSERVERS)
def test_wide_beams_and_biased_poses(observer: str) -> None:
    """Objects near the fan's axis, where what elevation might do is told but does not happen."""
    for case in ON_AXIS:
        nees, moving = errors(case, observer)
        assert 0.4 < nees < 2.5, case.name
        # A yaw that is wrong by 1 deg makes a third of what rests seem to creep past a vehicle under way.
        assert moving == pytest.approx(float(case.object_speed > 0.0), abs=0.4), case.name


def test_what_creeps_unseen_is_told() -> None:
    """Before, the means were 3.4, 4.1 and 3.1 (8 runs of `benchmarks.tracker.consistency`)."""
    for speed, told_s in CREEPING:
        case = Case("creeping", 50.0, 0.1, object_speed=speed)
        found = [one_run(case, "manoeuvring", np.random.default_rng([0, run]), [told_s]) for run in range(8)]
        assert np.nanmean([one.nees for one in found]) < 2.5, speed


@pytest.mark.parametrize("case", MOVING, ids=lambda case: case.name)
def test_what_moves_is_not_taken_to_climb(case: Case) -> None:
    """A climb that was imagined carried heights away within 30 s, at a NEES of 50 and 13."""
    found = [one_run(case, "manoeuvring", np.random.default_rng([7, run]), (20.0, 30.0)) for run in range(RUNS)]
    nees = np.concatenate([one.nees for one in found], axis=1)
    assert np.isfinite(nees).mean() > 0.7
    assert np.nanmean(nees) < 2.8


def test_a_climb_is_not_taken_for_a_height() -> None:
    """Each ping said the same wrong thing of the height, and it was believed each time: a NEES of 3.1 on average."""
    found = [one_run(CLIMBING, "manoeuvring", np.random.default_rng([7, run]), (20.0, 30.0)) for run in range(2 * RUNS)]
    nees = np.concatenate([one.nees for one in found], axis=1)
    assert np.isfinite(nees).mean() > 0.7
    assert np.nanmean(nees) < 2.5
