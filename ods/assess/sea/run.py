"""Runs a scene through the chain and the tracker without sockets: the list that a planner would receive for each
ping."""

import hashlib
import math
import time
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from ods.base import clock
from ods.base.arrays import Floats, Ints
from ods.base.errors import OdsError
from ods.base.frames.geometry import rotation_matrix
from ods.messages import Detections, Ping, Truth
from ods.nav_bridge.settings import SigmaSettings
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.pose.buffer import PoseEstimate
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.ins.sigmas import USUAL_SIGMAS
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.shots import Shot, shots_of
from ods.sim_sonar.sonar.model import SonarModel
from ods.tracker.measurement.from_detections import received
from ods.tracker.output.bottom import bottom_below
from ods.tracker.output.hittable import ReportableFilter
from ods.tracker.output.surface import View
from ods.tracker.output.validity import SETTLE_S
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker


class DetectedPing(NamedTuple):
    """One ping: the truth and the chain's detections."""

    truth: Truth
    found: Detections
    chain_ms: float


class Listed(NamedTuple):
    """One ping: the truth and the published list."""

    truth: Truth
    detections: int
    id: Ints
    """(n,) ids of the objects in the list."""
    state: Ints
    """(n,) states, as in `lifecycle`."""
    place: Floats
    """(n, 2) north, east, m."""
    radius: Floats
    """(n,) radius, m."""
    chain_ms: float
    tracker_ms: float
    valid: bool
    """False: in the first second, in which no list is."""
    heard_from_db: float
    """What an echo has to be over the background; NaN: not reported."""


def scene_with_seed(file: Path, seed: int) -> Scene:
    """Return the scene of a file; seed 0: as it is, others: another sea-bed and other speckle. Raises ConfigError."""
    scene = load_scene(file)
    return Scene(msgspec.structs.replace(scene.file, seed=scene.file.seed + 1000 * seed)) if seed else scene


def images_of(scene: Scene, sonar: SonarModel, seconds: float, kept: Path | None = None) -> Iterator[Shot]:
    """Yield the pings of a scene's first seconds; from the folder `kept`, if they are there, else into it.

    Raises OdsError.
    """
    count = int(min(seconds, scene.file.duration_s) / sonar.ping_period_s) + 1
    shots = islice(shots_of(ImageSimulator(sonar, scene)), count)
    if kept is None:
        yield from shots
        return
    name = hashlib.sha256(msgspec.json.encode([scene.file, sonar.name, sonar.beams, sonar.samples, count])).hexdigest()
    path = kept / f"{name[:16]}.pings"
    try:
        if not path.is_file():
            path.write_bytes(msgspec.msgpack.encode(list(shots)))
        pairs: list[tuple[Ping, Truth]] = msgspec.msgpack.decode(path.read_bytes(), type=list[tuple[Ping, Truth]])
    except (OSError, msgspec.MsgspecError) as error:
        raise OdsError(f"{path}: {error}") from error
    yield from (Shot(*pair) for pair in pairs)


def detected(
    shots: Iterable[Shot], scene: Scene, pipeline: PipelineSettings, *, knows_altitude: bool = True
) -> Iterator[DetectedPing]:
    """Yield what the chain finds in pings, in order; knows_altitude: the vehicle's pose reports it. Raises OdsError."""
    chain = Chain(pipeline)
    for ping, truth in shots:
        head = head_at(scene, ping.t_ns, knows_altitude=knows_altitude)
        began = time.perf_counter()
        found = chain.process(ping, pose=head)
        yield DetectedPing(truth, found, 1e3 * (time.perf_counter() - began))


def listed(
    pings: Iterable[DetectedPing], scene: Scene, settings: TrackerSettings, *, knows_altitude: bool = True
) -> list[Listed]:
    """Return the tracker's lists for the detections of pings, in order. Raises OdsError."""
    tracker, hittable = Tracker(settings), ReportableFilter(settings)
    lists: list[Listed] = []
    for truth, found, chain_ms in pings:
        head = head_at(scene, found.t_ns, knows_altitude=knows_altitude)
        began = time.perf_counter()
        tracker.step(received(found, head, lambda t_ns: head_at(scene, t_ns), found.utc_ns).scan)
        spent = chain_ms, 1e3 * (time.perf_counter() - began)
        view = View(found.utc_ns, head, found.sector.half_vertical_rad)
        listed = hittable.of(tracker.snapshot(), bottom_below(head), view)
        places = listed.position[:2].T.copy()
        valid = bool(lists) and found.t_ns - lists[0].truth.t_ns >= SETTLE_S * clock.NS
        heard_from_db = math.nan if found.heard_from_db is None else found.heard_from_db
        of_list = listed.id, listed.state, places, listed.radius, *spent, valid, heard_from_db
        lists.append(Listed(truth, len(found.detections), *of_list))
    return lists


def head_at(scene: Scene, t_ns: int, *, knows_altitude: bool = True) -> PoseEstimate:
    """Return the true pose of the sonar's head, and its altitude, with the standard deviations of the bench's INS."""
    t_s = t_ns / clock.NS
    (place, attitude), vehicle = scene.head_at(t_s), scene.vehicle_at(t_s)
    velocity = rotation_matrix(vehicle.attitude) @ vehicle.velocity_body
    sigma_position, sigma_attitude = np.array(USUAL_SIGMAS.position), np.array(USUAL_SIGMAS.attitude)
    altitude = scene.sea_bed.altitude_of(place) if knows_altitude and scene.sea_bed is not None else None
    sigmas = sigma_position, sigma_attitude, 0.0
    return PoseEstimate(t_ns, place, attitude, velocity, *sigmas, altitude, SigmaSettings().altitude_m)
