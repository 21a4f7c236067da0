"""Sources of pings: a file, or a scene that is simulated when it is viewed. Opened once, then read by place."""

import threading
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path

from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.base.files.lazy_sequence import LazySequence, place_after
from ods.base.geodesy import LocalFrame
from ods.base.settings_file import load
from ods.messages import Ping, Pose, Truth
from ods.offline.poses import PoseTrack, pose_track_of
from ods.offline.recorded import Indexed, TruthsByNumber, is_recording
from ods.offline.truths import truths_beside
from ods.recording.mcap.reader import open_recording
from ods.sim_sonar.scene.settings import SceneFile
from ods.sonar_link.files.fan_image import FanGeometry
from ods.sonar_link.files.opening import open_pings
from ods.workbench.engine.files.folders import readable
from ods.workbench.model.state import DataReference

NONE_OPEN = "no data are open: open a recording or a scene (O), or an example in the menu Demonstrator"
KEPT_BYTES = 16 << 20
"""Of samples of the last pings, which are kept: going back is at once."""
LONGEST_S = 86_400.0
"""Of a scene: its whole path is laid out when it is opened."""
FAN_SUFFIX = ".toml"
"""Of the file beside a clip that holds the fan's geometry: pike1.toml beside pike1.avi."""
PERIOD_PINGS = 8
"""Number of pings from whose times the period is taken."""


class DataError(OdsError):
    """The data cannot be opened; the text is one line."""


class KeptPings(LazySequence[Ping]):
    """Pings of anywhere, of which the last ones are kept. May be used from several threads."""

    def __init__(self, pings: Sequence[Ping], most_bytes: int = KEPT_BYTES) -> None:
        self._pings, self._most_bytes = pings, most_bytes
        self._kept: OrderedDict[int, Ping] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self._pings)

    def item(self, place: int) -> Ping:
        """Return one. Raises OdsError where the file is bad."""
        with self._lock:
            if place not in self._kept:
                self._keep(place, self._pings[place])
            self._kept.move_to_end(place)
            return self._kept[place]

    def _keep(self, place: int, ping: Ping) -> None:
        self._kept[place] = ping
        self._bytes += len(ping.data)
        while self._bytes > self._most_bytes and len(self._kept) > 1:
            _, old = self._kept.popitem(last=False)
            self._bytes -= len(old.data)


@dataclass(frozen=True, eq=False)
class Data:
    """Pings with poses and truth. May be used from several threads."""

    reference: DataReference
    pings: Sequence[Ping]
    """Made when they are asked for; asking may raise OdsError."""
    poses: Sequence[Pose] = ()
    """In order of time, or of receipt where a recording has them; none: nothing can be tracked."""
    timed: bool = True
    """False: single images, of which no time is known."""
    truths: Mapping[int, Truth] = field(default_factory=dict)
    """By ping number; of a scene, those of the pings that were asked for; empty: not known."""
    losses: Mapping[str, int] = field(default_factory=dict)
    """What the file holds and the pings do not, by kind."""
    frame: LocalFrame | None = None
    """Where the poses' origin is, as far as it is known."""

    def t_s(self, place: int) -> float:
        """Return the time of a ping since the first one, s; of single images their number."""
        if not self.timed:
            return float(place)
        return (self.pings[place].t_ns - self._first_ns) / NS

    def truth(self, place: int) -> Truth | None:
        """Return the truth of a ping."""
        return self.truths.get(self.pings[place].ping_number)

    def poses_about(self, t_ns: int, before: int) -> Sequence[Pose]:
        """Return this number of poses up to an instant, and the one after it."""
        after = place_after(self.poses, t_ns, lambda pose: pose.t_ns)
        return self.poses[max(0, after - before) : after + 1]

    @cached_property
    def poses_in_time(self) -> list[Pose]:
        """All poses in order of time, which reads them all: not for the server's loop."""
        return sorted(self.poses, key=lambda pose: pose.t_ns)

    @cached_property
    def _first_ns(self) -> int:
        return self.pings[0].t_ns

    @cached_property
    def period_s(self) -> float | None:
        """The time between pings: the median of the first few; none: not known."""
        count = min(len(self.pings), PERIOD_PINGS)
        if not self.timed or count < 2:
            return None
        times = [self.t_s(place) for place in range(count)]
        steps = sorted(later - sooner for sooner, later in pairwise(times))
        return steps[len(steps) // 2] if steps[len(steps) // 2] > 0.0 else None


def open_data(reference: DataReference, scene: SceneFile | None, folders: Sequence[Path]) -> Data:
    """Open what a state refers to. Raises OdsError, one line.

    scene: `State.scene`; folders: that files may be read from.
    """
    match reference.kind:
        case "scene":
            return _simulated(reference, scene, folders)
        case "file":
            return _from_file(reference, readable(reference.path, folders))
    raise DataError(NONE_OPEN if reference.kind == "none" else f"{reference.kind}: has no pings")


def _simulated(reference: DataReference, scene: SceneFile | None, folders: Sequence[Path]) -> Data:
    """Return a scene's pings, as a sonar sees them that is given by name or by a file in `folders`. Raises OdsError."""
    from ods.offline.source import simulated  # the simulator and scipy: only for scenes
    from ods.sim_sonar.by_name import find_sonar
    from ods.sim_sonar.scene.timeline import Scene

    if scene is None:
        raise DataError("scene: none is open")
    if scene.duration_s > LONGEST_S:
        raise DataError(f"scene: duration_s: {scene.duration_s:g} s is more than the {LONGEST_S:g} s shown here")
    if reference.sonar.endswith(".toml"):
        readable(reference.sonar, folders)
    elif "/" in reference.sonar:
        raise DataError(f"sonar: {reference.sonar} is not a name")
    model = find_sonar(reference.sonar, Path(reference.path) if reference.path else None)
    try:
        source = simulated(Scene(scene), model)
    except ValueError as error:
        raise DataError(f"scene: {error}") from error
    return Data(reference, KeptPings(source.pings), source.poses, truths=source.truths)


def _from_file(reference: DataReference, path: Path) -> Data:
    """Open a recording of pings of any format; poses and truth where it has them."""
    if path.suffix == ".toml":
        raise DataError(f"{path}: a scene is opened as such")
    if is_recording(path):
        return _from_recording(reference, path)
    geometry = path.with_suffix(FAN_SUFFIX)
    fan = load(geometry, FanGeometry) if path.suffix.lower() == ".avi" and geometry.is_file() else None
    recording = open_pings(path, fan)
    if not len(recording.pings):
        raise DataError(f"{path}: no pings in it")
    try:
        way = pose_track_of(path, recording) if recording.timed else PoseTrack([], None)
    except OdsError:
        way = PoseTrack([], None)
    truths = truths_beside(path)
    return Data(reference, KeptPings(recording.pings), way.poses, recording.timed, truths, recording.losses, way.frame)


def _from_recording(reference: DataReference, path: Path) -> Data:
    """Open a recording of `ods record`: by its index, and what is asked for is read."""
    recorded = Indexed(open_recording(path))
    if not recorded.pings:
        raise DataError(f"{path}: no pings in it")
    truths = TruthsByNumber(recorded.truths)
    return Data(reference, KeptPings(recorded.pings), recorded.poses, True, truths, recorded.losses)
