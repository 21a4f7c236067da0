"""Chain and tracker as on board, without sockets: the list that a planner would receive for each ping."""

import time
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from ods.base.frames.mounting import MountingSettings
from ods.base.geodesy import SiteSettings
from ods.base.settings import Settings
from ods.config import part_of
from ods.messages import Detections, ObstacleList, Ping, Pose
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.processor import PingProcessor
from ods.pipeline.settings import PipelineConfig, PipelineSettings
from ods.pose.buffer import PoseSettings
from ods.pose.utc import VehicleUtc
from ods.sonar_link.ping_builder import listening_ns
from ods.tracker.mission import MissionTracker
from ods.tracker.output.validity import InputMonitor
from ods.tracker.settings import TrackerConfig, TrackerSettings


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


class Found(NamedTuple):
    """The chain's result for one ping, and the data needed to track it later."""

    ping_number: int
    t_ns: int
    """Time of the ping's transmission."""
    utc_ns: int
    """UTC of the ping's transmission."""
    ended_ns: int
    """When its last echo had come, or been read."""
    poses: list[Pose]
    """Poses that came after those of the ping before."""
    detections: Detections | None
    """None: it was a bad ping."""
    chain_ms: float


class Detecting:
    """The chain of one run over pings. `counters`: those of the pipeline, bad_ping."""

    def __init__(self, settings: MissionSettings, counters: "Counter[str] | None" = None) -> None:
        """Raises PluginError, StageError."""
        self.counters: Counter[str] = Counter() if counters is None else counters
        self._processor = PingProcessor(part_of(settings, PipelineConfig), self.counters)

    def found(self, pings: Iterable[Ping], poses: Iterable[Pose]) -> Iterator[tuple[Ping, Found]]:
        """Yield what is found in each ping; poses and pings stand in order of time. Raises StageError.

        Of each ping the poses are known up to the first one after its last echo, as on board by the time it is read.
        """
        waiting = iter(poses)
        received_ns: int | None = None
        for ping in pings:
            ended_ns = _end_of_reception_ns(ping)
            taken: list[Pose] = []
            while received_ns is None or received_ns < ended_ns:
                pose = next(waiting, None)
                if pose is None:
                    break
                self._processor.add_pose(pose)
                taken.append(pose)
                received_ns = pose.t_ns
            began = time.perf_counter()
            detections = self._detections(ping)
            spent_ms = 1e3 * (time.perf_counter() - began)
            until_ns = max(ended_ns, ping.t_rx_ns)
            yield ping, Found(ping.ping_number, ping.t_ns, ping.utc_ns, until_ns, taken, detections, spent_ms)

    def _detections(self, ping: Ping) -> Detections | None:
        try:
            return self._processor.process(ping)
        except PingError:
            self.counters["bad_ping"] += 1
            return None


class Tracking:
    """The tracker of one run over what was found. `counters`: those of the tracker, detections_late."""

    def __init__(self, settings: MissionSettings, counters: "Counter[str] | None" = None) -> None:
        self.counters: Counter[str] = Counter() if counters is None else counters
        self._settings = part_of(settings, TrackerConfig)
        self.tracker: MissionTracker | None = None
        """None before the first ping."""

    def list_of(self, found: Found) -> ObstacleList | None:
        """Return the list of one ping; None: it was bad, or came late. Raises PluginError."""
        tracker = self.tracker = self.tracker or self._tracker_from(found)
        for pose in found.poses:
            tracker.add_pose(pose)
        if found.detections is None:
            return None
        tracker.follow_utc(found.ended_ns)
        tracked = tracker.track(found.detections, found.ended_ns)
        return None if tracked is None else tracked.message

    def _tracker_from(self, found: Found) -> MissionTracker:
        inputs = InputMonitor(found.t_ns, (), lambda _: "")
        utc = VehicleUtc(found.t_ns, found.utc_ns - found.t_ns, "unsure")
        return MissionTracker(self._settings, inputs, utc, counters=self.counters)


class Mission:
    """One run over pings. `counters`: those of pipeline and tracker, bad_ping, detections_late."""

    def __init__(self, settings: MissionSettings) -> None:
        """Raises PluginError, StageError."""
        self.counters: Counter[str] = Counter()
        self._detecting = Detecting(settings, self.counters)
        self._tracking = Tracking(settings, self.counters)

    def steps(self, pings: Iterable[Ping], poses: Iterable[Pose]) -> Iterator[Step]:
        """Yield what comes of each ping; poses and pings stand in order of time. Raises StageError."""
        for ping, found in self._detecting.found(pings, poses):
            began = time.perf_counter()
            message = self._tracking.list_of(found)
            spent_ms = 1e3 * (time.perf_counter() - began)
            if message is not None and found.detections is not None:
                yield Step(ping, found.detections, message, found.chain_ms, spent_ms)


def _end_of_reception_ns(ping: Ping) -> int:
    return ping.t_ns + (listening_ns(ping) if ping.sound_speed > 0.0 else 0)
