"""Images of a vehicle that moves and turns while the echoes come back, against closed forms."""

import math
from pathlib import Path

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.sim_sonar.echo.bodies.bodies import BODY, Bodies, middles
from ods.sim_sonar.echo.bodies.motion_during_reception import as_received
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.pose import Times, VehiclePose
from ods.sim_sonar.scene.settings import Cylinder, Oscillation, Plane, SceneFile, Sphere, VehiclePath
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sea_bed.settings import Roughness, SeaBed
from ods.sim_sonar.sonar.model import load_sonar

SEABAT = load_sonar(Path(__file__).parents[2] / "config/sonars/seabat6012.toml")
RATE = math.radians(20.0)
"""Of turn to starboard at scene time 0."""
SWING = Oscillation(amplitude_deg=40.0, period_s=4.0 * math.pi)

NO_SWING = Oscillation()


def scene(*objects: Sphere | Cylinder | Plane, speed: float = 0.0, yaw: Oscillation = SWING) -> Scene:
    vehicle = VehiclePath(position_ned=(0.0, 0.0, 0.0), velocity_ned=(speed, 0.0, 0.0), yaw=yaw)
    return Scene(SceneFile(seed=1, vehicle=vehicle, objects=list(objects), duration_s=1.0))


def assert_alike(received: Bodies, expected: Bodies, without: str = "") -> None:
    for name in BODY.names or ():
        if name != without:
            np.testing.assert_allclose(received[name], expected[name], atol=1e-12)


@pytest.mark.parametrize(("range_m", "bearing_deg"), [(95.0, 0.0), (95.0, -30.0), (60.0, 20.0), (20.0, 0.0)])
def test_a_point_is_seen_in_the_beam_of_the_attitude_at_reception(range_m: float, bearing_deg: float) -> None:
    def point(bearing_rad: float) -> Sphere:
        place = range_m * math.cos(bearing_rad), range_m * math.sin(bearing_rad), 0.0
        return Sphere(name="a", position_ned=place, radius_m=0.1)

    bearing, turned = math.radians(bearing_deg), RATE * 2.0 * range_m / SEABAT.sound_speed
    area = ImageSimulator(SEABAT, scene(point(bearing))).mean_area(0.0)
    off_peak = SEABAT.bearing_rad[area.max(axis=1).argmax()] - (bearing - turned)
    assert abs(off_peak) <= 0.5 * math.radians(1.5) + 1e-9
    turned = math.radians(40.0) * math.sin(range_m / SEABAT.sound_speed)  # exactly
    at_rest = ImageSimulator(SEABAT, scene(point(bearing - turned), yaw=NO_SWING)).mean_area(0.0)
    np.testing.assert_allclose(area, at_rest, rtol=1e-6, atol=1e-12 * at_rest.max())


@pytest.mark.parametrize("range_m", [30.0, 60.0, 95.0])
def test_a_rough_bed_is_seen_in_the_direction_of_the_attitude_at_reception(range_m: float) -> None:
    bed = SeaBed(depth_m=5.0, rough=Roughness(rms_height_m=0.25, correlation_m=2.0))

    def around(heading_deg: float, yaw: Oscillation) -> Floats:
        vehicle = VehiclePath(position_ned=(0.0, 0.0, 0.0), heading_deg=heading_deg, yaw=yaw)
        seen = Scene(SceneFile(seed=1, vehicle=vehicle, sea_bed=bed, duration_s=1.0))
        near = np.abs(SEABAT.range0_m + SEABAT.dr_m * np.arange(SEABAT.samples) - range_m) < 0.5
        return ImageSimulator(SEABAT, seen).mean_area(0.0)[:, near]

    def error(image: Floats) -> float:
        return float(np.linalg.norm(image - at_rest) / np.linalg.norm(at_rest))

    at_rest = around(40.0 * math.sin(range_m / SEABAT.sound_speed), NO_SWING)
    assert error(around(0.0, SWING)) < 0.1 * error(around(0.0, NO_SWING))


def test_the_range_is_half_the_way_there_and_back() -> None:
    """Head on at v: p = c t / 2 + v t / 2, hence r = c t / 2 = p / (1 + v / c)."""
    target = Scene(scene(Sphere(name="a", position_ned=(90.0, 0.0, 0.0), radius_m=1.0)).file)
    speed = 15.0

    def pose_at(t_s: Times) -> VehiclePose:
        level = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (*np.shape(t_s), 4))
        return VehiclePose(np.multiply.outer(t_s, [speed, 0.0, 0.0]), level)

    received = as_received(target.bodies_at(0.0), 0.0, pose_at(0.0), 1500.0, pose_at)
    assert received["centre"][0, 0] == pytest.approx(90.0 / (1.0 + speed / 1500.0), abs=0.02)
    assert received["centre"][0, 0] < 89.2
    assert_alike(received, target.bodies_at(0.0), without="centre")


def test_a_wall_and_a_pipe_are_turned_about_their_nearest_points() -> None:
    wall = Plane(name="quay", position_ned=(60.0, 500.0, 0.0), normal_ned=(1.0, 0.0, 0.0))
    pipe = Cylinder(name="pipe", position_ned=(40.0, 300.0, 3.0), axis_ned=(0.0, 1.0, 0.0), radius_m=0.3, length_m=1e3)
    turning = scene(wall, pipe)
    received = as_received(turning.bodies_at(0.0), 0.0, turning.pose_at(0.0), 1500.0, turning.pose_at)
    for row, nearest in enumerate([np.array([60.0, 0.0, 0.0]), np.array([40.0, 0.0, 3.0])]):
        distance = float(np.linalg.norm(nearest))
        turned = RATE * 2.0 * distance / 1500.0
        back = geometry.rotation_matrix(geometry.quat_from_euler(0.0, 0.0, -turned))
        np.testing.assert_allclose(received["axes"][row, 2], back @ turning.bodies_at(0.0)["axes"][row, 2], atol=2e-4)
        middle = middles(received, np.zeros(3))[row]
        np.testing.assert_allclose(middle, back @ nearest, atol=0.01)


def test_the_truth_knows_where_the_echo_is() -> None:
    """Off the beam of the attitude at transmission by more than its radius, and out of the fan altogether."""
    ahead = Sphere(name="ahead", position_ned=(95.0, 0.0, 0.0), radius_m=1.0)
    east, north = 90.0 * math.sin(math.radians(-43.0)), 90.0 * math.cos(math.radians(-43.0))
    leaving = Sphere(name="leaving", position_ned=(north, east, 0.0), radius_m=1.0)
    images = ImageSimulator(SEABAT, scene(ahead, leaving))
    truth = {item.name: item for item in images.truth(0.0)}
    assert truth["ahead"].position_ned == (95.0, 0.0, 0.0)
    assert truth["ahead"].peak_db == pytest.approx(20.0 * np.log10(images.mean_image(0.0).max()), abs=0.01)
    assert truth["ahead"].in_sector
    assert not truth["leaving"].in_sector


def test_a_vehicle_at_rest_hears_objects_where_they_are() -> None:
    still = scene(Sphere(name="a", position_ned=(40.0, 3.0, 1.0), radius_m=2.0), yaw=NO_SWING)
    assert_alike(
        as_received(still.bodies_at(0.0), 0.0, still.pose_at(0.0), 1500.0, still.pose_at), still.bodies_at(0.0)
    )
    empty = scene()
    assert len(as_received(empty.bodies_at(0.0), 0.0, empty.pose_at(0.0), 1500.0, empty.pose_at)) == 0
