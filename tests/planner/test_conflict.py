"""The chance constraint, against numbers by hand and against drawn places."""

import math
from typing import Any

import numpy as np
import pytest

from ods.messages import Clearance, Obstacle, PoseAt
from ods.planner.conflict import HIT, conflict
from ods.planner.paths import Motion, instants, paths_of
from ods.planner.settings import SteeringSettings
from ods.planner.unknown import OWN_M, unknown_m
from tests.planner.lists import obstacle, predicted

SETTINGS = SteeringSettings(vehicle_radius_m=0.0, keep_m=3.0, risk=0.01, certain_s=5.0, expected_s=15.0)
NORTH = Motion(np.zeros(2), 0.0, 2.0, np.zeros(2))
Z = 2.3263478740408408
"""99 % of a normal distribution lie below so many standard deviations."""


def bad(*obstacles: Obstacle, settings: SteeringSettings = SETTINGS, age_s: float = 0.0) -> float:
    paths = paths_of(NORTH, np.zeros(1), 2.0, settings)
    return float(conflict(paths, obstacles, age_s, settings)[0])


@pytest.mark.parametrize("sigma", [0.0, 0.5, 1.0])
def test_the_distance_kept_is_that_of_the_risk(sigma: float) -> None:
    """Abreast at 4 m north, 2 s ahead: 1 m radius, 3 m to keep, 2.33 standard deviations."""
    least = 1.0 + 3.0 + Z * sigma
    known: dict[str, Any] = {"sigma_position": (sigma, sigma, 0.0), "sigma_radius": 0.0}
    assert bad(obstacle(4.0, least + 0.01, **known)) == 0.0
    assert bad(obstacle(4.0, least - 0.01, **known)) > 0.0


def test_drawn_places_are_too_near_as_often_as_the_risk_says() -> None:
    rng = np.random.default_rng(1)
    sigma, at_m = 0.8, 4.0 + Z * 0.8
    lateral = at_m + sigma * rng.standard_normal(200_000)
    assert np.mean(lateral - 1.0 < 3.0) == pytest.approx(0.01, rel=0.1)
    known: dict[str, Any] = {"sigma_position": (0.0, sigma, 0.0), "sigma_radius": 0.0}
    assert bad(obstacle(4.0, at_m + 0.02, **known)) == 0.0 < bad(obstacle(4.0, at_m - 0.02, **known))


def test_what_may_not_exist_is_kept_off_less_and_what_hardly_does_not_at_all() -> None:
    def kept(existence: float, bottom: float = 0.0) -> float:
        east = np.arange(3.5, 8.0, 0.01)
        known: dict[str, Any] = {"sigma_position": (1.0, 1.0, 0.0), "sigma_radius": 0.0}
        each = (obstacle(4.0, e, existence=existence, bottom_probability=bottom, **known) for e in east)
        return float(max((e for e, o in zip(east, each, strict=True) if bad(o) > 0.0), default=0.0))

    assert kept(1.0) == pytest.approx(4.0 + Z, abs=0.02)
    assert kept(0.1) == pytest.approx(4.0 + 1.2816, abs=0.02)  # 90 % of a normal distribution
    assert kept(0.2, 0.5) == pytest.approx(kept(0.1), abs=0.02)
    assert kept(0.01) == 0.0


def test_the_ellipse_counts_by_its_longest_half_axis() -> None:
    """Errors of north and east that go together: variances 1 and covariance 0.9 make 1.9 along the diagonal."""
    known: dict[str, Any] = {"sigma_position": (1.0, 1.0, 0.0), "sigma_radius": 0.0, "covariance_ne": 0.9}
    least = 4.0 + Z * math.sqrt(1.9)
    assert bad(obstacle(4.0, least + 0.01, **known)) == 0.0 < bad(obstacle(4.0, least - 0.01, **known))


def test_a_moving_obstacle_counts_where_it_will_be() -> None:
    crossing = obstacle(20.0, -10.0, velocity_ned=(0.0, 1.0, 0.0))
    assert bad(crossing) > 0.0
    assert bad(obstacle(20.0, -10.0)) == 0.0
    assert bad(obstacle(20.0, -10.0, velocity_ned=(0.0, 3.0, 0.0))) == 0.0, "it is through long before"
    assert bad(obstacle(20.0, -20.0, velocity_ned=(0.0, 1.0, 0.0)), age_s=10.0) > 0.0, "the list is old"


def test_uncertainty_grows_as_predicted_and_fades_as_newer_lists_come() -> None:
    at_5_s = obstacle(10.0, 8.0)
    surer = obstacle(10.0, 8.0, predicted=predicted(at_5_s, (5.0, 0.2)))
    vaguer = obstacle(10.0, 8.0, predicted=predicted(at_5_s, (5.0, 2.5)))
    assert bad(surer) == 0.0 < bad(vaguer)
    at_15_s = obstacle(30.0, 5.0)
    assert bad(obstacle(30.0, 5.0, predicted=predicted(at_15_s, (5.0, 0.2), (10.0, 0.2), (20.0, 9.0)))) == 0.0


@pytest.mark.parametrize("state", ["active", "stand_by", "hibernated"])
def test_no_state_but_terminated_is_ignored(state: str) -> None:
    assert bad(obstacle(10.0, 0.0, state=state)) > 0.0
    assert bad(obstacle(10.0, 0.0, state="terminated")) == 0.0


def test_through_it_is_worse_than_past_it() -> None:
    assert bad(obstacle(10.0, 0.0)) > 20.0 * bad(obstacle(10.0, 2.5)) > 0.0


def test_paths_turn_no_faster_than_the_vehicle_and_drift_with_the_water() -> None:
    settings = SteeringSettings(turn_rate_deg_s=10.0)
    paths = paths_of(NORTH._replace(drift=np.array([0.0, 0.5])), np.radians([0.0, 90.0, -90.0]), 2.0, settings)
    legs = np.diff(paths.places, axis=1) / np.diff(paths.t_s)[:, None] - (0.0, 0.5)
    course = np.arctan2(legs[..., 1], legs[..., 0])
    middle = 0.5 * (paths.t_s[1:] + paths.t_s[:-1])
    assert (np.abs(np.diff(course, axis=1)) <= math.radians(10.0) * np.diff(middle) + 1e-9).all()
    assert np.degrees(course[:, -1]) == pytest.approx([0.0, 90.0, -90.0])
    assert np.allclose(np.hypot(*legs.T), 2.0)
    assert paths.t_s[-1] == settings.horizon_s
    assert np.all(np.diff(instants(30.0)) > 0.0)


def test_what_no_path_comes_near_costs_nothing_and_changes_nothing() -> None:
    """The sum over many obstacles, near and far, is that of each by itself: nothing near is left out."""
    rng = np.random.default_rng(2)
    paths = paths_of(NORTH, np.radians(np.arange(0.0, 360.0, 30.0)), 2.0, SETTINGS)
    for _ in range(200):
        place, velocity = rng.uniform(-150.0, 150.0, 2), rng.uniform(-1.5, 1.5, 2)
        sigma = float(rng.uniform(0.0, 4.0))
        each = obstacle(*place, sigma_position=(sigma, sigma, 0.0), velocity_ned=(*velocity, 0.0))
        offset = paths.places - (place + paths.t_s[:, None] * velocity)
        share = np.clip((15.0 - paths.t_s) / 10.0, 0.0, 1.0)
        room = np.hypot(*offset.T).T - 1.0 - 3.0 - Z * share * math.hypot(sigma, 0.1)
        assert ((room < 0.0).any(axis=1) == (conflict(paths, [each], 0.0, SETTINGS) > 0.0)).all()


def test_what_an_operator_said_to_ignore_needs_no_distance() -> None:
    assert bad(obstacle(4.0, 0.0)) > 0.0
    assert bad(obstacle(4.0, 0.0, ignored_by=0)) == 0.0


def test_badness_is_the_integral_over_time_of_the_worst_squared_lack() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        paths = paths_of(NORTH, np.radians(np.arange(0.0, 360.0, 15.0)), 2.0, SETTINGS)
        known: dict[str, Any] = {"sigma_position": (0.0, 0.0, 0.0), "sigma_radius": 0.0}
        spots = rng.uniform((-30.0, -30.0, 0.2), (30.0, 30.0, 4.0), (5, 3)).tolist()
        listed = [obstacle(*spot, **known) for spot in spots]
        places = np.array([each.position_ned[:2] for each in listed])
        away = np.hypot(*(paths.places[:, None] - places[:, None]).transpose(3, 0, 1, 2))
        edge = away - np.array([each.radius_m for each in listed])[:, None] - SETTINGS.vehicle_radius_m
        lack = np.maximum(SETTINGS.keep_m - edge, 0.0)
        worst = (lack**2 * np.where(edge < 0.0, HIT, 1.0)).max(axis=1)
        expected = worst @ np.diff(paths.t_s, prepend=0.0)
        np.testing.assert_allclose(conflict(paths, listed, 0.0, SETTINGS), expected, rtol=1e-9, atol=1e-9)


def test_no_path_goes_farther_than_its_reach() -> None:
    now = Motion(np.array([3.0, -2.0]), 0.4, 1.0, np.array([0.3, -0.6]))
    paths = paths_of(now, np.radians(np.arange(0.0, 360.0, 30.0)), 2.0, SETTINGS)
    away = np.hypot(*(paths.places - paths.start).reshape(-1, 2).T)
    assert away.max() <= paths.reach_m < 1.5 * away.max()


@pytest.mark.parametrize("sectors", [16, 72])
def test_unknown_water_is_what_is_not_called_empty_step_by_step(sectors: int) -> None:
    rng = np.random.default_rng(sectors)
    start = np.array([5.0, -7.0])
    places = start + np.cumsum(rng.uniform(-1.5, 2.5, (40, 12, 2)), axis=1)
    near, to = rng.uniform(0.0, 3.0, sectors), rng.uniform(0.0, 25.0, sectors)
    nearest = [float(each) if each > 8.0 else None for each in rng.uniform(1.0, 20.0, sectors)]
    pose = PoseAt((5.0, -7.0, 3.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 3, (0.0,) * 3, (0.0,) * 3)
    clearance = Clearance(0, 0, 0, 0, True, near.tolist(), to.tolist(), nearest, pose=pose)
    expected = np.zeros(len(places))
    for path, along in enumerate(places - start):
        before = 0.0
        for north, east in along.tolist():
            away = math.hypot(north, east)
            sector = int(math.atan2(east, north) % (2.0 * math.pi) / (2.0 * math.pi) * sectors)
            body = nearest[sector]
            beyond = away > OWN_M or (body is not None and away > body)
            if away <= 15.0 and not near[sector] <= away <= to[sector] and beyond:
                expected[path] += max(0.0, away - before)
            before = away
    np.testing.assert_allclose(unknown_m(places, clearance, 15.0), expected, atol=1e-9)
    assert 0.0 < expected.mean() < 15.0
