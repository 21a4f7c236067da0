"""Obstacles at another time: closed forms, and never surer than the tracker itself would be."""

from pathlib import Path

import numpy as np
import pytest
import zmq
from hypothesis import given, strategies as st

from ods.base.clock import NS
from ods.client import NoListError, Obstacles, at
from ods.client.extrapolation import spread_along
from ods.messages import Obstacle, ObstacleList, Prediction
from ods.runtime import bus
from ods.tracker.output.obstacle_list import ObstacleLister
from ods.tracker.settings import BottomSettings, MotionSettings, PlannerSettings
from tests.tracker.test_approach import objects

T_NS = 100 * NS
MOVING = Obstacle(
    id=7, state="active", position_ned=(30.0, -2.0, 9.0), velocity_ned=(0.5, -1.0, 0.25), radius_m=1.5,
    sigma_position=(0.3, 0.4, 3.0), sigma_velocity=(0.1, 0.2, 0.0), sigma_radius=0.1, first_seen_utc_ns=0,
    last_seen_utc_ns=20 * NS, times_seen=9, existence=1.0, covariance_ne=0.05,
)  # fmt: skip


def obstacle_list(*obstacles: Obstacle) -> ObstacleList:
    return ObstacleList(0, 0, T_NS, T_NS, T_NS, True, [], list(obstacles))


def test_place_and_covariance_in_closed_form() -> None:
    (ahead,) = at(obstacle_list(MOVING), T_NS + 4 * NS)
    assert ahead.obstacle == MOVING
    assert ahead.position_ned == pytest.approx((32.0, -6.0, 10.0))
    assert np.array(ahead.covariance) == pytest.approx(
        np.array([[0.7**2, 0.05, 0.0], [0.05, 1.2**2, 0.0], [0.0, 0.0, 9.0]])
    )
    (before,) = at(obstacle_list(MOVING), T_NS - 4 * NS)
    assert before.position_ned == pytest.approx((28.0, 2.0, 8.0))
    assert before.covariance == ahead.covariance


def test_what_ended_is_not_ahead() -> None:
    gone = Obstacle(**{name: getattr(MOVING, name) for name in MOVING.__struct_fields__} | {"state": "terminated"})
    assert at(obstacle_list(gone), T_NS) == []


def test_manoeuvres_add_what_the_predictions_say_and_time_cubed_beyond() -> None:
    fields = {name: getattr(MOVING, name) for name in MOVING.__struct_fields__}
    reported = [Prediction(10.0, (0.0, 0.0, 0.0), (np.sqrt(1.3**2 + 5.0), 2.4, 3.0))]
    turning = obstacle_list(Obstacle(**fields | {"predicted": reported}))
    north = [at(turning, T_NS + s * NS)[0].covariance[0][0] for s in (0, 5, 10, 20)]
    assert north == pytest.approx([0.3**2, 0.8**2 + 2.5, 1.3**2 + 5.0, 2.3**2 + 40.0])


@given(
    st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 60.0),
    st.sampled_from([(), (5.0, 10.0, 20.0), (20.0, 5.0), (0.0, 7.0, 7.0)]),
)  # fmt: skip
def test_never_surer_than_the_tracker(static: float, restless: float, lead_s: float, leads: tuple[float, ...]) -> None:
    motion = MotionSettings()
    snapshot = objects([[30.0, 5.0, 8.0]], [[0.4, -0.8, 0.0]])
    snapshot.static[:], snapshot.restless[:] = static, restless
    lister = ObstacleLister(PlannerSettings(lead_times_s=leads), motion, BottomSettings())
    (ahead,) = at(obstacle_list(*lister.obstacles(snapshot)), T_NS + round(lead_s * NS))
    fit = lister._fit(snapshot)
    wanted = fit.extrapolated(lead_s if leads else 0.0, motion).sigma_position[:, 0] ** 2
    assert np.all(np.diag(ahead.covariance) >= wanted * (1.0 - 1e-6))
    if lead_s in leads:
        assert np.diag(ahead.covariance) == pytest.approx(wanted)


def test_spread_along_a_direction_is_that_of_the_matrix() -> None:
    (ahead,) = at(obstacle_list(MOVING), T_NS)
    unit = np.array([0.6, -0.8])
    matrix = np.array(ahead.covariance)[:2, :2]
    assert spread_along(ahead, 6.0, -8.0) == pytest.approx(np.sqrt(unit @ matrix @ unit))
    assert spread_along(ahead, 0.0, 0.0) == pytest.approx(0.4)


def test_the_client_carries_its_newest_list_on(tmp_path: Path) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = bus.Publisher(context, tmp_path, "tracker")
    client = Obstacles(tmp_path, stale_s=0.2)
    with pytest.raises(NoListError, match="no obstacle list received yet"):
        client.at(T_NS)
    while not client.next().valid:
        publisher.publish("obstacles", obstacle_list(MOVING))
    assert client.at(T_NS + 4 * NS) == at(obstacle_list(MOVING), T_NS + 4 * NS)
    publisher.close()
    client.close()
    context.term()
