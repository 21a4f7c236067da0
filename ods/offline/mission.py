"""Chain and tracker as on board, without sockets: what a planner would have been told of each ping."""

import time
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from ods.base.geodesy import SiteSettings
from ods.base.mounting import MountingSettings
from ods.base.settings import Settings
from ods.config import part_of
from ods.messages import Detections, ObstacleList, Ping, Pose
from ods.pipeline.plan import PingError
from ods.pipeline.processor import PingProcessor
from ods.pipeline.settings import PipelineConfig, PipelineSettings
from ods.runtime.pose_buffer import PoseSettings
from ods.sonar_link.ping_builder import listening_ns
from ods.tracker.mission import MissionTracker
from ods.tracker.output.validity import InputMonitor
from ods.tracker.settings import TrackerConfig, TrackerSettings
from ods.tracker.utc import VehicleUtc


class MissionSettings(Settings, frozen=True):
    """What pipeline and tracker read of a configuration."""

    site: SiteSettings = SiteSettings(latitude_deg=0.0, longitude_deg=0.0)
    """The origin of the poses."""
    pipeline: PipelineSettings = PipelineSettings()
    tracker: TrackerSettings = TrackerSettings()
    mounting: MountingSettings = MountingSettings()
    pose: PoseSettings = PoseSettings()


class Step(NamedTuple):
    """What came of one ping."""

    ping: Ping
    detections: Detections
    list: ObstacleList
    chain_ms: float
    tracker_ms: float


class Mission:
    """One run over pings. `counters`: those of pipeline and tracker, bad_ping, detections_late."""

    def __init__(self, settings: MissionSettings) -> None:
        """Raises PluginError, StageError."""
        self.counters: Counter[str] = Counter()
        self._settings = settings
        self._processor = PingProcessor(part_of(settings, PipelineConfig), self.counters)
        self._tracker: MissionTracker | None = None

    def steps(self, pings: Iterable[Ping], poses: Iterable[Pose]) -> Iterator[Step]:
        """Yield what comes of each ping; poses and pings stand in order of time. Raises StageError.

        Of each ping the poses are known up to the first one after its last echo, as on board by the time it is read.
        """
        waiting = iter(poses)
        heard_ns: int | None = None
        for ping in pings:
            tracker = self._tracker = self._tracker or self._tracker_from(ping)
            ended_ns = _end_of_reception_ns(ping)
            while heard_ns is None or heard_ns < ended_ns:
                pose = next(waiting, None)
                if pose is None:
                    break
                self._processor.hear_pose(pose)
                tracker.hear_pose(pose)
                heard_ns = pose.t_ns
            step = self._step(ping, tracker, max(ended_ns, ping.t_rx_ns))
            if step is not None:
                yield step

    def _step(self, ping: Ping, tracker: MissionTracker, now_ns: int) -> Step | None:
        began = time.perf_counter()
        try:
            found = self._processor.process(ping)
        except PingError:
            self.counters["bad_ping"] += 1
            return None
        between = time.perf_counter()
        tracker.follow_utc(now_ns)
        told = tracker.track(found, now_ns)
        spent = 1e3 * (between - began), 1e3 * (time.perf_counter() - between)
        return None if told is None else Step(ping, found, told.message, *spent)

    def _tracker_from(self, ping: Ping) -> MissionTracker:
        inputs = InputMonitor(ping.t_ns, (), lambda _: "")
        utc = VehicleUtc(ping.t_ns, ping.utc_ns - ping.t_ns, "unsure")
        return MissionTracker(part_of(self._settings, TrackerConfig), inputs, utc, counters=self.counters)


def _end_of_reception_ns(ping: Ping) -> int:
    return ping.t_ns + (listening_ns(ping) if ping.sound_speed > 0.0 else 0)
