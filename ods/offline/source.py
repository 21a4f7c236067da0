"""Whatever `ods track` takes: recordings of pings, those of `ods record`, scenes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.base.geodesy import LocalFrame
from ods.messages import Ping, Pose, Truth
from ods.offline.poses import pose_track_of, poses_along
from ods.offline.recorded import Indexed, is_recording
from ods.offline.truths import truths_beside
from ods.recording.mcap.reader import open_recording
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.sonar.model import SonarModel
from ods.sonar_link.files.fan_image import FanGeometry
from ods.sonar_link.files.opening import open_pings
from ods.sonar_link.files.ping_sequence import LazyPings


@dataclass(frozen=True)
class Source:
    """Pings with the vehicle's poses."""

    pings: Sequence[Ping]
    """Made when they are asked for."""
    poses: Sequence[Pose]
    """In order of time."""
    truths: Mapping[int, Truth] = field(default_factory=dict)
    """By ping number; of a scene, those of the pings that were asked for; empty: not known."""
    losses: Mapping[str, int] = field(default_factory=dict)
    frame: LocalFrame | None = None
    """Where the poses' origin is, as far as the file reports."""


def open_source(path: Path, *, sonar: str, fan: FanGeometry | None = None, site: LocalFrame | None = None) -> Source:
    """Open a scene (.toml), which `sonar` sees, or a recording with poses. Raises OdsError, one line.

    site: the origin of geographic positions; none: where the first pose is.
    """
    if path.suffix == ".toml":
        return scene_source(path, sonar)
    return recorded_source(path, fan, site)


def recorded_source(path: Path, fan: FanGeometry | None = None, site: LocalFrame | None = None) -> Source:
    """Open a recording with poses, of any format; their `t_ns` are of one clock. Raises OdsError, one line."""
    if is_recording(path):
        return _segments_source(path, site)
    recording = open_pings(path, fan)
    if not recording.timed:
        raise OdsError(f"{path}: its pings have no times, so they cannot be tracked")
    poses, frame = pose_track_of(path, recording, site)
    return Source(recording.pings, poses, truths_beside(path), recording.losses, frame)


def scene_source(path: Path, sonar: str) -> Source:
    """Return the pings of a whole scene, as `ods simulate` writes them. Raises OdsError."""
    scene, model = load_scene(path), find_sonar(sonar, path)
    try:
        return simulated(scene, model)
    except ValueError as error:
        raise OdsError(f"{path}: {error}") from error


def simulated(scene: Scene, model: SonarModel) -> Source:
    """Return the pings of a scene that a sonar sees. Raises ValueError where they do not fit."""
    from ods.sim_sonar.image import ImageSimulator  # with scipy 40 MB: not where recordings are opened
    from ods.sim_sonar.shots import START_UTC_NS, shot_at

    images = ImageSimulator(model, scene)
    truths: dict[int, Truth] = {}

    def make(number: int) -> Ping:
        try:
            ping, truths[number] = shot_at(images, number)
        except ValueError as error:  # levels of this ping that no amplitude holds
            raise OdsError(f"scene: {error}") from error
        return ping

    count = int(scene.file.duration_s / model.ping_period_s) + 1
    shots = range(count)
    times = [round(number * model.ping_period_s * 1e9) for number in shots]
    path = scene.pose_at(np.array(times) / NS)
    attitudes = [tuple(attitude) for attitude in path.attitude.tolist()]
    return Source(LazyPings(count, make), poses_along(times, path.position_ned, attitudes, START_UTC_NS), truths)


def _segments_source(path: Path, site: LocalFrame | None) -> Source:
    recorded = Indexed(open_recording(path))
    pings, poses = recorded.pings.readable(), sorted(recorded.poses, key=lambda pose: pose.t_ns)
    if not pings or not poses:
        raise OdsError(f"{path}: no {'poses' if pings else 'pings'} in it")
    truths = {truth.ping_number: truth for truth in recorded.truths}
    return Source(pings, poses, truths, recorded.losses, site)
