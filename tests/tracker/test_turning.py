"""A vehicle that swings at up to 20 deg/s: simulated images through the pipeline and the tracker."""

import math
from pathlib import Path

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.frames.geometry import euler_from_quat
from ods.messages import Detections, Pose
from ods.pipeline.offline import detect_pings
from ods.pipeline.settings import PipelineSettings
from ods.pose.buffer import PoseBuffer
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.settings import Oscillation, SceneFile, Sphere, VehiclePath
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sea_bed.settings import SeaBed
from ods.sim_sonar.sonar.model import load_sonar
from ods.tracker.existence.lifecycle import ACTIVE
from ods.tracker.measurement.pose import motion_during_reception
from ods.tracker.measurement.scan import Scan, echo_table_of, echoes_of, vehicle_at
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker

SEABAT = load_sonar(Path(__file__).parents[2] / "config/sonars/seabat6012.toml")
SECONDS, SETTLED_S = 12.0, 3.0
PERIOD_S = 4.0
PLACES = ((30.0, 3.0), (60.0, -8.0), (92.0, 4.0))
"""North and east of the objects, m."""


@pytest.fixture(scope="module")
def scene() -> Scene:
    yaw = Oscillation(amplitude_deg=20.0 * PERIOD_S / math.tau, period_s=PERIOD_S)
    path = VehiclePath(position_ned=(0.0, 0.0, 20.0), velocity_ned=(0.3, 0.0, 0.0), yaw=yaw)
    surface = Surface(cd=0.1, cs=0.05)
    balls = [
        Sphere(name=f"{north:.0f} m", position_ned=(north, east, 20.5), radius_m=1.5, surface=surface)
        for north, east in PLACES
    ]
    bed = SeaBed(depth_m=23.1, surface=Surface(cd=0.5, cs=0.2, sigma_deg=20.0))
    file = SceneFile(seed=4, duration_s=SECONDS, shadows=False, vehicle=path, objects=list(balls), sea_bed=bed)
    return Scene(file)


@pytest.fixture(scope="module")
def found(scene: Scene) -> list[Detections]:
    images = ImageSimulator(SEABAT, scene)
    times = np.arange(int(SECONDS / SEABAT.ping_period_s)) * SEABAT.ping_period_s
    pings = (images.ping(t, k, round(t * NS), round(t * NS)) for k, t in enumerate(times.tolist()))
    return [result.detections for result in detect_pings(pings, PipelineSettings())]


@pytest.fixture(scope="module")
def poses(scene: Scene) -> PoseBuffer:
    """The INS's, at 100 Hz."""
    buffer = PoseBuffer(10_000, 0.3)
    for k in range(round(100 * (SECONDS + 1.0))):
        vehicle = scene.vehicle_at(0.01 * k)
        n, e, d = vehicle.position_ned.tolist()
        w, x, y, z = vehicle.attitude.tolist()
        u, v, down = vehicle.velocity_body.tolist()
        buffer.insert(
            Pose(k, k * NS // 100, 0, (n, e, d), (w, x, y, z), (u, v, down), (0.1,) * 3, (0.002, 0.002, 0.005))
        )
    return buffer


def errors(found: list[Detections], poses: PoseBuffer, *, at_reception: bool) -> Floats:
    """Return the (lists, objects) distances, m, to the nearest active obstacle once settled."""
    tracker = Tracker(TrackerSettings())
    rows = []
    for message in found:
        sent = poses.at(message.t_ns)
        assert sent is not None
        echoes, turn = echoes_of(echo_table_of(message.detections))[0], 0.0
        if at_reception:
            listening = motion_during_reception.poses_of(
                sent, message.sector.range_max_m, message.sound_speed, poses.at
            )
            assert listening is not None
            echoes, turn = motion_during_reception.at_transmission(echoes, listening)
        vehicle = vehicle_at(sent.position_ned, sent.attitude, sent.sigma_position, sent.sigma_attitude)
        tracker.step(Scan(message.t_ns, message.utc_ns, vehicle, message.sector, echoes, fan_turn=turn))
        picture = tracker.snapshot()
        north, east = picture.position[:2, picture.state == ACTIVE]
        if message.t_ns > SETTLED_S * NS:
            rows.append([np.hypot(north - n, east - e).min() for n, e in PLACES])
    return np.array(rows)


def test_the_scene_turns_at_20_deg_a_second(scene: Scene) -> None:
    headings = [float(euler_from_quat(scene.vehicle_at(t).attitude)[2]) for t in np.arange(0.0, PERIOD_S, 0.01)]
    assert math.degrees(np.abs(np.diff(headings)).max() / 0.01) == pytest.approx(20.0, abs=0.1)


def test_objects_stay_where_they_are_while_the_vehicle_turns(found: list[Detections], poses: PoseBuffer) -> None:
    """Of single echoes the place is off by up to 3.9 m without reception; of tracks, what the filters leave of it."""
    right = np.sqrt(np.mean(errors(found, poses, at_reception=True) ** 2, axis=0))
    wrong = np.sqrt(np.mean(errors(found, poses, at_reception=False) ** 2, axis=0))
    print("position error, m rms, by object: with", right.round(2), "without", wrong.round(2))
    assert right.max() < 1.0
    assert wrong[-1] > 2.0 * right[-1]
