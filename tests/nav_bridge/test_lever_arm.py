"""Poses of an INS that is not at the body's origin, against a vehicle on a circle whose motion is known."""

import math

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.frames.mounting import spread_at
from ods.base.geodesy import LocalFrame
from ods.messages import Pose
from ods.nav_bridge.lever_arm import LeverArm
from ods.sim_sonar.ins.place import InsPlace
from ods.sim_sonar.scene.settings import Oscillation, SceneFile, VehiclePath, Waypoint
from ods.sim_sonar.scene.timeline import Scene

LEVER = (-3.0, 0.5, 0.8)
RATE, RADIUS = math.radians(20.0), 12.0
"""Of turn to starboard, rad/s, and of the circle, m."""


def on_circle(t_s: float) -> tuple[Pose, Floats, Floats]:
    """Return what the INS tells, and the origin's place, NED, and velocity, body: level, along the circle."""
    yaw = RATE * t_s
    origin = np.array([RADIUS * math.sin(yaw), RADIUS * (1.0 - math.cos(yaw)), 10.0])
    turn = np.array([[math.cos(yaw), -math.sin(yaw), 0.0], [math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    velocity = np.array([RATE * RADIUS, 0.0, 0.0])
    swing = np.array([-RATE * LEVER[1], RATE * LEVER[0], 0.0])
    north, east, down = (origin + turn @ LEVER).tolist()
    u, v, w = (velocity + swing).tolist()
    attitude = (math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw))
    t_ns = round(t_s * NS)
    return Pose(0, t_ns, t_ns, (north, east, down), attitude, (u, v, w), (0.1,) * 3, (0.01,) * 3), origin, velocity


def test_place_and_velocity_on_a_circle() -> None:
    arm = LeverArm(LEVER)
    for k in range(50):
        told, origin, velocity = on_circle(0.01 * k)
        pose = arm.at_origin(told)
        np.testing.assert_allclose(pose.position_ned, origin, atol=1e-9)
        if k:
            np.testing.assert_allclose(pose.velocity_body, velocity, atol=1e-5)
        assert max(abs(np.subtract(told.velocity_body, velocity))) > 1.0
    np.testing.assert_allclose(pose.sigma_position_ned, spread_at(
        tuple(np.subtract(told.position_ned, origin).tolist()), (0.1,) * 3, (0.01,) * 3))  # fmt: skip


def test_after_a_gap_the_rate_of_turn_is_not_known_and_taken_for_none() -> None:
    arm = LeverArm(LEVER)
    for t_s in (0.0, 3.0, 2.0):
        told, origin, _ = on_circle(t_s)
        pose = arm.at_origin(told)
        np.testing.assert_allclose(pose.position_ned, origin, atol=1e-9)
        assert pose.velocity_body == pytest.approx(told.velocity_body)


def test_an_ins_at_the_origin_is_passed_on_as_it_is() -> None:
    told, _, _ = on_circle(1.0)
    assert LeverArm((0.0, 0.0, 0.0)).at_origin(told) is told


def test_the_simulated_ins_on_its_lever_tells_what_leads_back_to_the_vehicle() -> None:
    swing = Oscillation(amplitude_deg=10.0, period_s=4.0)
    points = [Waypoint(t_s=t, position_ned=(n, e, 5.0)) for t, n, e in ((0, 0, 0), (5, 8, 1), (10, 12, 9))]
    path = VehiclePath(waypoints=points, follow_path=True, yaw=swing, pitch=swing, roll=swing)
    scene, place = Scene(SceneFile(seed=1, vehicle=path)), InsPlace(LocalFrame(57.0, 10.0), LEVER)
    arm = LeverArm(LEVER)
    for k in range(400, 500):
        position, attitude, velocity = place.told(scene, 0.01 * k)
        told = Pose(
            k, k * NS // 100, 0, tuple(position.tolist()), attitude, tuple(velocity.tolist()), (0.0,) * 3, (0.0,) * 3
        )
        pose, vehicle = arm.at_origin(told), scene.vehicle_at(0.01 * k)
        np.testing.assert_allclose(pose.position_ned, vehicle.position_ned, atol=1e-4)  # 2e-6 rad from the site's north
        if k > 400:
            np.testing.assert_allclose(pose.velocity_body, vehicle.velocity_body, atol=0.01)
