"""Runs pipeline and tracker again on a recorded mission, with the on-board code and the recorded inputs."""

from collections import Counter, deque
from collections.abc import Iterator
from typing import NamedTuple

import msgspec

from ods.base.clock import NS
from ods.config import OnboardConfig, part_of
from ods.messages import Detections, ObstacleList, Ping, VetoOrder
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.processor import PingProcessor
from ods.pipeline.settings import PipelineConfig
from ods.pipeline.stage.params import StageError
from ods.pose.utc import VehicleUtc
from ods.recording.mcap.reader import Recorded, Recording
from ods.replay.setup import TrackerLife, pipeline_starts, recorded_map, tracker_lives
from ods.replay.streams import DetectionsStream, HealthStream, OrderStream, PoseStream, message_of
from ods.runtime.processes import PROCESSES
from ods.tracker.map.keeper import of_earlier_mission
from ods.tracker.mission import MissionTracker
from ods.tracker.output.validity import InputMonitor
from ods.tracker.restart.checkpoint import MissionState
from ods.tracker.restart.ids import reserved_id
from ods.tracker.settings import TrackerConfig
from ods.tracker.veto.vetoes import RefusedError

PATIENCE_NS = 2 * NS
"""A ping received this much later than its detections, or never, counts as missing."""

STARTED_NS = NS
"""A tracker starts at most this time before the first ping that it lists: what it stamps lies behind its start, what
is in the map before it."""


class DetectionsPair(NamedTuple):
    """The detections of one ping."""

    log_ns: int
    recorded: Detections
    data: bytes
    """As recorded."""
    again: Detections | None
    """None: not available, see the counters."""


class ListPair(NamedTuple):
    """One obstacle list."""

    recorded: ObstacleList
    data: bytes
    again: ObstacleList | None


class PipelineRerun:
    """The pipeline once more. `counters`: missing_pings, missing_poses, failed_pings, pipeline_restarts."""

    def __init__(self, recording: Recording, config: OnboardConfig, counters: "Counter[str]") -> None:
        """Raises PluginError, StageError."""
        self.counters = counters
        self._recording = recording
        self._settings = part_of(config, PipelineConfig)
        self._processor = PingProcessor(self._settings)
        self._poses = PoseStream(recording)
        self._starts = deque(pipeline_starts(recording))
        self._pings: deque[Ping] = deque()
        self._waiting: deque[tuple[Recorded, Detections]] = deque()

    def run(self) -> Iterator[DetectionsPair]:
        """Yield the detections of each ping that has some, in order. Raises RecordingError."""
        for recorded in self._recording.messages(["ping", "detections"]):
            message = message_of(self._recording, recorded)
            if isinstance(message, Ping):
                self._pings.append(message)
            elif isinstance(message, Detections):
                self._waiting.append((recorded, message))
            yield from self._work_off(recorded.log_ns)
        yield from self._work_off(None)
        self.counters["missing_poses"] += self._poses.missing

    def _work_off(self, now_ns: int | None) -> Iterator[DetectionsPair]:
        """Yield what can be: None: there is no more to wait for."""
        while self._waiting:
            recorded, found = self._waiting[0]
            ping = next((ping for ping in self._pings if _is_of(found, ping)), None)
            if ping is None and now_ns is not None and now_ns < recorded.log_ns + PATIENCE_NS:
                return
            self._waiting.popleft()
            self.counters["missing_pings"] += ping is None
            again = None if ping is None else self._process(ping, recorded, found)
            while self._pings and (self._pings[0].t_rx_ns < found.t_rx_ns or _is_of(found, self._pings[0])):
                self._pings.popleft()
            yield DetectionsPair(recorded.log_ns, found, recorded.data, again)

    def _process(self, ping: Ping, recorded: Recorded, found: Detections) -> Detections | None:
        if self._starts and recorded.log_ns >= self._starts[0]:
            self._starts.popleft()
            self.counters["pipeline_restarts"] += 1
            self._processor = PingProcessor(self._settings)
            self._poses.begin()
        for pose in self._poses.until(found, recorded.log_ns):
            self._processor.add_pose(pose)
        try:
            return self._processor.process(ping)
        except (PingError, StageError):
            self.counters["failed_pings"] += 1
            return None


def _is_of(found: Detections, ping: Ping) -> bool:
    """Return whether the detections are those of a ping; of a mechanically scanned sonar they have another `t_ns`."""
    return (found.seq, found.t_rx_ns) == (ping.seq, ping.t_rx_ns)


class TrackerRerun:
    """The tracker once more, over given detections.

    `counters`: missing_detections, missing_lists, missing_poses, tracker_restarts (those that went on where the former
    one was), tracker_anew (those that did not, as far as lists show).
    """

    def __init__(self, recording: Recording, config: OnboardConfig, counters: "Counter[str]") -> None:
        """Raises OdsError."""
        self.counters = counters
        self._recording = recording
        self._settings = part_of(config, TrackerConfig)
        sigma_m = self._settings.tracker.map.position_sigma_m
        known = recorded_map(recording)
        self._known = [of_earlier_mission(o, sigma_m) for o in known]
        self._lives: deque[TrackerLife] = deque(tracker_lives(recording, known))
        self.lists = sum(life.lists for life in self._lives)
        self._poses, self._health = PoseStream(recording), HealthStream(recording)
        self._orders = OrderStream(recording)
        self._tracker: MissionTracker | None = None

    def run(self, detections: Iterator[tuple[int, Detections]]) -> Iterator[ListPair]:
        """Yield each list, as recorded and once more. Raises RecordingError, PluginError."""
        found = DetectionsStream(detections)
        for recorded in self._recording.messages(["obstacles"]):
            original = message_of(self._recording, recorded)
            if isinstance(original, ObstacleList):
                yield ListPair(original, recorded.data, self._again(original, found))
        self.counters["missing_poses"] += self._poses.missing

    def _again(self, original: ObstacleList, found: DetectionsStream) -> ObstacleList | None:
        tracker = self._tracker_of(original)
        for pose in self._poses.until(original, original.made_ns):
            tracker.add_pose(pose)
        for report in self._health.until(original.made_ns):
            tracker.add_health(report)
        for order in self._orders.until(original.made_ns):
            self._follow(tracker, order)
        self.counters["missing_lists"] += max(0, original.seq - tracker.seq)
        tracker.seq = original.seq
        tracker.follow_utc(original.made_ns)
        if original.ping_number < 0:
            return tracker.silent_list(original.made_ns)
        of_ping = found.of(original.t_ns)
        if of_ping is None:
            self.counters["missing_detections"] += 1
            return None
        answer = tracker.track(of_ping, original.made_ns)
        return None if answer is None else answer.message

    def _follow(self, tracker: MissionTracker, order: VetoOrder) -> None:
        """Let an operator's order be carried out; here it may name what is not there."""
        try:
            tracker.follow(order.request, order.author, order.t_ns)
        except RefusedError:
            self.counters["refused_orders"] += 1

    def _tracker_of(self, original: ObstacleList) -> MissionTracker:
        """Return the tracker that made a list: one whose lists restart took over from the former one."""
        former = self._tracker
        if former is not None and original.seq >= former.seq:
            return former
        first_id = self._lives.popleft().first_id
        utc = VehicleUtc(original.t_ns - STARTED_NS, original.utc_ns - original.t_ns, original.utc_source)
        watches = PROCESSES["tracker"].watches
        tracker = MissionTracker(
            self._settings, InputMonitor(original.made_ns, watches, lambda _: ""), utc, first_id=first_id
        )
        if former is not None and _goes_on(original, former):
            self.counters["tracker_restarts"] += 1
            left: MissionState = msgspec.msgpack.decode(msgspec.msgpack.encode(former.state([], [])), type=MissionState)
            tracker.restore(left, left.map_changes.put, reserved_id(former.tracker.next_id))
        else:
            self.counters["tracker_anew"] += former is not None
            tracker.seq = original.seq
            tracker.tracker.join(self._known, first_id)
        self._poses.begin()
        self._tracker = tracker
        return tracker


def _goes_on(original: ObstacleList, former: MissionTracker) -> bool:
    """Return whether a new tracker's first list knows what the former tracker's objects were."""
    live = {o.id for o in original.obstacles if o.state != "hibernated"}
    return bool(live & set(former.tracker.snapshot().id.tolist())) or not len(former.tracker.snapshot())
