"""A sonar tilted, or ahead of the vehicle's origin: simulator, pipeline and tracker against other matrices."""

import math
from collections import Counter
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ods.base.clock import NS
from ods.base.frames.mounting import Mounting, MountingSettings
from ods.base.geodesy import SiteSettings
from ods.messages import Detection, Detections, ObstacleList, Pose
from ods.pipeline.offline import detect_pings
from ods.pipeline.settings import PipelineSettings
from ods.pose.buffer import PoseBuffer, PoseSettings
from ods.pose.head import head_of
from ods.runtime.processes import PROCESSES
from ods.runtime.service import Service
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.settings import SceneFile, Sphere, VehiclePath
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sonar.model import load_sonar
from ods.tracker.measurement.model import position_measurement
from ods.tracker.measurement.scan import echo_table_of, echoes_of, vehicle_at
from ods.tracker.service import TrackerWorker
from ods.tracker.settings import TrackerProcessConfig, TrackerSettings

SEABAT = load_sonar(Path(__file__).parents[2] / "config/sonars/seabat6012.toml")
AT_ORIGIN = MountingSettings()
TILTED = MountingSettings(pitch_deg=-15.0)
AHEAD = MountingSettings(position_m=(3.0, 0.0, 0.0))
VEHICLE_NED, HEADING_DEG = (20.0, -10.0, 12.0), 40.0
RADIUS_M = 0.3
Place = NDArray[np.float64]
EXACT = (0.0, 0.0, 0.0)


def in_world(mounting: MountingSettings, distance_m: float, bearing: float, elevation: float, body: Rotation) -> Place:
    """Return eq. 1 with a mounting, by scipy's rotations."""
    turned = [mounting.yaw_deg, mounting.pitch_deg, mounting.roll_deg]
    head = Rotation.from_euler("ZYX", turned, degrees=True)
    level = distance_m * math.cos(elevation)
    seen = [level * math.cos(bearing), level * math.sin(bearing), -distance_m * math.sin(elevation)]
    return np.asarray(body.apply(head.apply(seen) + mounting.position_m) + VEHICLE_NED)


def pose_at(t_ns: int, body: Rotation) -> Pose:
    w, x, y, z = body.as_quat(scalar_first=True).tolist()
    return Pose(0, t_ns, t_ns, VEHICLE_NED, (w, x, y, z), EXACT, EXACT, EXACT)


class Desk:
    """What the tracker's worker asks of its process; keeps what it publishes."""

    def __init__(self, mounting: MountingSettings, run_dir: Path) -> None:
        self.lists: list[ObstacleList] = []
        service = SimpleNamespace(
            counters=Counter(),
            process=PROCESSES["tracker"],
            run_dir=run_dir,
            publish=self.publish,
            log_once=print,
            overload=str,
        )
        site = SiteSettings(latitude_deg=57.0, longitude_deg=10.0)
        config = TrackerProcessConfig(site=site, pose=PoseSettings(), tracker=TrackerSettings(), mounting=mounting)
        self.worker = TrackerWorker(cast(Service, service), config)
        self.worker.start()

    def publish(self, topic: str, message: Any) -> None:
        if topic == "obstacles":
            self.lists.append(message)

    def place(self, found: list[Detections], body: Rotation) -> Place:
        """Track; return the place of the one obstacle."""
        for message in found:
            for ms in range(-10, 300, 10):
                self.worker.handle("pose", pose_at(message.t_ns + ms * NS // 1000, body))
            self.worker.handle("detections", message)
            self.worker.tick()
        (obstacle,) = next(picture.obstacles for picture in reversed(self.lists) if picture.ping_number >= 0)
        return np.array(obstacle.position_ned)


def images_of(mounting: MountingSettings, place: Place) -> list[Detections]:
    """Return the detections in two seconds of simulated images of a small sphere."""
    path = VehiclePath(position_ned=VEHICLE_NED, heading_deg=HEADING_DEG, mounting=mounting)
    north, east, down = place.tolist()
    ball = Sphere(name="ball", position_ned=(north, east, down), radius_m=RADIUS_M, surface=Surface(cd=0.5))
    images = ImageSimulator(SEABAT, Scene(SceneFile(seed=3, vehicle=path, objects=[ball])))
    times = np.arange(12) * SEABAT.ping_period_s
    pings = (images.ping(t, k, round((t + 1.0) * NS), round(t * NS)) for k, t in enumerate(times.tolist()))
    return [result.detections for result in detect_pings(pings, PipelineSettings())]


@pytest.mark.parametrize(
    ("mounted", "believed", "wrong_m"),
    [
        (TILTED, TILTED, (0.0, 0.0)),
        (TILTED, AT_ORIGIN, (1.7, -12.9)),
        (AHEAD, AHEAD, (0.0, 0.0)),
        (AHEAD, AT_ORIGIN, (-3.0, 0.0)),
    ],
    ids=["tilted", "tilted, not reported", "ahead", "ahead, not reported"],
)
def test_an_object_on_the_axis_from_image_to_obstacle_list(
    mounted: MountingSettings, believed: MountingSettings, wrong_m: tuple[float, float], tmp_path: Path
) -> None:
    """Head 15 deg down, or 3 m ahead; the errors, ahead and down, are those found when it could not be reported."""
    body = Rotation.from_euler("Z", HEADING_DEG, degrees=True)
    place = in_world(mounted, 50.0, 0.0, 0.0, body)
    ahead, right, down = body.inv().apply(Desk(believed, tmp_path).place(images_of(mounted, place), body) - place)
    assert ahead == pytest.approx(wrong_m[0], abs=RADIUS_M)
    assert right == pytest.approx(0.0, abs=0.4)  # a beam is 1.3 m wide there, and the axis lies between two
    assert down == pytest.approx(wrong_m[1], abs=0.1)


ANGLES = st.tuples(st.floats(-179.0, 179.0), st.floats(-89.0, 89.0), st.floats(-179.0, 179.0))


@given(
    place=st.tuples(*[st.floats(-10.0, 10.0)] * 3),
    mounted=ANGLES,
    attitude=ANGLES,
    echo=st.tuples(st.floats(5.0, 100.0), st.floats(-0.7, 0.7), st.floats(-0.15, 0.15)),
)
def test_any_echo_of_any_head_is_where_it_should_be(
    place: tuple[float, float, float],
    mounted: tuple[float, float, float],
    attitude: tuple[float, float, float],
    echo: tuple[float, float, float],
) -> None:
    roll, pitch, yaw = mounted
    settings = MountingSettings(position_m=place, roll_deg=roll, pitch_deg=pitch, yaw_deg=yaw)
    body = Rotation.from_euler("ZYX", attitude, degrees=True)
    buffer = PoseBuffer(2, 0.1)
    buffer.insert(pose_at(0, body))
    head = head_of(buffer.at(0), Mounting(settings))
    assert head is not None
    vehicle = vehicle_at(head.position_ned, head.attitude, head.sigma_position, head.sigma_attitude)
    assert vehicle is not None
    distance_m, bearing, elevation = echo
    reported = Detection(distance_m, bearing, 0.5, 9.0, 9.0, 9.0, 9, 1.0, 0.1, 0.1, 1e-4, 0.1, elevation_rad=elevation)
    found = position_measurement(echoes_of(echo_table_of([reported]))[0], vehicle, 0.2).position[:, 0]
    np.testing.assert_allclose(found, in_world(settings, distance_m, bearing, elevation, body), atol=1e-3)


def test_a_lever_adds_what_attitude_errors_do_to_it() -> None:
    buffer = PoseBuffer(2, 0.1)
    reported = pose_at(0, Rotation.identity())
    buffer.insert(Pose(0, 0, 0, VEHICLE_NED, reported.attitude, EXACT, (0.1, 0.1, 0.1), (0.02, 0.02, 0.05)))
    head = head_of(buffer.at(0), Mounting(AHEAD))
    assert head is not None
    np.testing.assert_allclose(head.sigma_position, [0.1, math.hypot(0.1, 0.15), math.hypot(0.1, 0.06)])
    np.testing.assert_allclose(head.sigma_attitude, (0.02, 0.02, 0.05))
    assert head_of(buffer.at(0), Mounting(AT_ORIGIN)) is not None
    assert head_of(None, Mounting(AHEAD)) is None
