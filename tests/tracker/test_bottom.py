"""What is the bottom, and what is over it: against bottoms and objects drawn by chance."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from ods.pose.buffer import PoseEstimate
from ods.tracker.map.map_object import MapObject
from ods.tracker.output.bottom import Bottom, bottom_below, heights_above_bottom, is_reportable
from ods.tracker.output.obstacle_list import ObstacleLister
from ods.tracker.output.snapshot import Snapshot, snapshot_of_map
from ods.tracker.settings import BottomSettings, MotionSettings, PlannerSettings

SETTINGS = BottomSettings(clearance_m=1.0, slope_deg=4.0, roughness_m=0.3)
BELOW = Bottom(np.array([10.0, -5.0, 25.0]), 0.2)
DRAWN = 400_000


def objects(*places: tuple[float, float, float, float]) -> Snapshot:
    """Objects of (north, east, down, standard deviation of down)."""
    return snapshot_of_map(
        [
            MapObject(i + 1, (n, e, d), (0.1, 0.1, s), 0.5, 0.1, 0.99, 9, 1, 2, 3)
            for i, (n, e, d, s) in enumerate(places)
        ]
    )


@pytest.mark.parametrize(
    ("down", "sigma"), [(25.0, 0.2), (24.8, 0.1), (24.2, 0.5), (22.0, 0.5), (24.0, 3.0), (25.6, 0.3), (20.0, 4.0)]
)
@pytest.mark.parametrize("away_m", [3.0, 30.0])
def test_the_probability_is_that_of_bottoms_and_objects_drawn_by_chance(
    down: float, sigma: float, away_m: float
) -> None:
    """Of all bottoms and objects there may be, those in which nothing is below the bottom."""
    rng = np.random.default_rng(3)
    stand = heights_above_bottom(objects((10.0, -5.0 + away_m, down, sigma)), BELOW, SETTINGS)
    bottom = BELOW.place[2] + rng.normal(0.0, BELOW.sigma_m, DRAWN) + rng.normal(0.0, SETTINGS.roughness_m, DRAWN)
    bottom += away_m * np.tan(np.radians(SETTINGS.slope_deg)) * rng.standard_normal(DRAWN)
    height = bottom - rng.normal(down, sigma, DRAWN)
    assert stand.height_m[0] == pytest.approx(height.mean(), abs=5.0 * height.std() / np.sqrt(DRAWN))
    assert stand.sigma_m[0] == pytest.approx(height.std(), rel=0.01)
    there = height[height > 0.0]
    assert stand.bottom[0] == pytest.approx((2.0 * there <= SETTINGS.clearance_m).mean(), abs=0.012)


@pytest.mark.parametrize("sigma", [0.05, 0.5, 2.0, 5.0])
def test_what_sticks_up_is_called_bottom_no_oftener_than_the_risk(sigma: float) -> None:
    """Stones on a bottom, 0 to 4 m high, seen with an honest deviation: of those left out the share that sticks up."""
    rng = np.random.default_rng(4)
    count = 20_000
    top = rng.uniform(0.0, 4.0, count)
    down = BELOW.place[2] + rng.normal(0.0, np.hypot(BELOW.sigma_m, 0.3), count) - 0.5 * top
    seen = objects(*((10.0, -5.0, float(d + rng.normal(0.0, sigma)), sigma) for d in down))
    left_out = ~is_reportable(seen, BELOW, SETTINGS)
    high = top > SETTINGS.clearance_m
    assert (left_out & high).sum() <= SETTINGS.risk * max(high.sum(), 1)
    if sigma < 0.1:
        exact = msgspec.structs.replace(SETTINGS, roughness_m=0.05)
        sure = replace_sigma(seen, 0.05)
        assert (~is_reportable(sure, Bottom(BELOW.place, 0.05), exact))[top < 0.2].any()


def replace_sigma(snapshot: Snapshot, down: float) -> Snapshot:
    sigma = snapshot.sigma_position.copy()
    sigma[2] = down
    return replace(snapshot, sigma_position=sigma)


@pytest.mark.parametrize("altitude_m", [2.0, 5.0, 10.0])
def test_a_sonar_of_one_plane_calls_nothing_bottom(altitude_m: float) -> None:
    """It knows of an object that it is within 10 degrees of its plane, which is level: no height follows from that."""
    ranges = np.arange(5.0, 100.0, 5.0)
    places = [(r, 0.0, 20.0, float(r * np.sin(np.radians(10.0)) / np.sqrt(3.0))) for r in ranges.tolist()]
    assert is_reportable(objects(*places), Bottom(np.array([0.0, 0.0, 20.0 + altitude_m]), 0.1), BottomSettings()).all()


def test_what_is_far_below_the_bottom_is_not_taken_for_it() -> None:
    """The bottom falls off there, and what stands in the depth may reach up to anywhere."""
    seen = objects((12.0, -5.0, 29.0, 0.2), (12.0, -5.0, 25.1, 0.2))
    sharp = msgspec.structs.replace(SETTINGS, roughness_m=0.05)
    assert heights_above_bottom(seen, BELOW, sharp).bottom[0] == 0.0
    assert heights_above_bottom(seen, BELOW, sharp).bottom[1] > 0.9


def test_without_an_altitude_nothing_is_said_and_nothing_left_out() -> None:
    zeros, seen = np.zeros(3), objects((12.0, -5.0, 25.0, 0.05))
    pose = PoseEstimate(0, np.array([0.0, 0.0, 20.0]), np.array([1.0, 0.0, 0.0, 0.0]), zeros, zeros, zeros, 0.0)
    assert bottom_below(pose) is None
    assert bottom_below(None) is None
    assert is_reportable(seen, None, SETTINGS).all()
    reported = ObstacleLister(PlannerSettings(), MotionSettings(), SETTINGS).obstacles(seen)[0]
    assert (reported.bottom_probability, reported.height_above_bottom_m, reported.sigma_height_above_bottom_m) == (
        0.0,
        None,
        None,
    )
    below = bottom_below(replace(pose, altitude_m=5.0, sigma_altitude_m=0.2))
    assert below is not None
    assert below.place.tolist() == [0.0, 0.0, 25.0]
    assert below.sigma_m == 0.2


def test_the_planner_hears_how_each_stands() -> None:
    seen = objects((10.0, -5.0, 24.9, 0.05), (10.0, -4.0, 20.0, 0.1))
    sharp, below = msgspec.structs.replace(SETTINGS, roughness_m=0.05), Bottom(BELOW.place, 0.05)
    stand = heights_above_bottom(seen, below, sharp)
    reported = ObstacleLister(PlannerSettings(), MotionSettings(), sharp).obstacles(seen, bottom=below)
    assert [each.bottom_probability for each in reported] == stand.bottom.tolist()
    assert [each.height_above_bottom_m for each in reported] == pytest.approx([0.1, 5.0])
    assert [each.sigma_height_above_bottom_m for each in reported] == stand.sigma_m.tolist()
    assert is_reportable(seen, below, sharp).tolist() == [False, True]
    assert is_reportable(seen, below, msgspec.structs.replace(sharp, list="all")).all()
