"""The tracker process: detections and poses from the bus, obstacle lists to the planner, the map on disk."""

import contextlib
import logging
import time
from functools import partial
from typing import Any

import msgspec

from ods.base import clock
from ods.base.mounting import Mounting
from ods.messages import Detections, ObstacleList, UtcSource
from ods.runtime import last_words
from ods.runtime.backlog import Backlog
from ods.runtime.head_pose import head_of
from ods.runtime.pose_buffer import PoseBuffer, PoseEstimate
from ods.runtime.service import Service, Worker
from ods.tracker.checkpoint import Checkpoints, Mission
from ods.tracker.map.keeper import MapKeeper, provisional_first_id
from ods.tracker.measurement.from_detections import received
from ods.tracker.measurement.scan import Vehicle
from ods.tracker.output.bottom import bottom_below, may_be_hit
from ods.tracker.output.closest_approach import Course
from ods.tracker.output.obstacle_list import ObstacleLister
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.output.validity import InputMonitor
from ods.tracker.settings import TrackerConfig
from ods.tracker.tracker import Tracker
from ods.tracker.utc import VehicleUtc
from ods.tracker.warm_up import warm_up

log = logging.getLogger(__name__)

FUTURE_NS = clock.NS
"""A ping stamped later than now by more than this has a wrong time."""

MAP_WAIT_S = 1.0
"""The first list waits so long for the map to be read; a disk that takes longer costs its objects until it is there."""


class TrackerWorker(Worker[TrackerConfig]):
    """Runs the tracker over what the bus brings."""

    def __init__(self, service: Service, settings: TrackerConfig) -> None:
        super().__init__(service, settings)
        self._poses = PoseBuffer(*msgspec.structs.astuple(settings.pose))
        self._poses_until = -1
        self._mounting = Mounting(settings.mounting)
        self._backlog: Backlog[Detections] = Backlog()
        self._ping_seq: int | None = None
        self._lister = ObstacleLister(settings.tracker.planner, settings.tracker.motion, settings.tracker.bottom)
        self._poses.counters = self._lister.counters = service.counters
        origin_deg = settings.site.latitude_deg, settings.site.longitude_deg
        self._checkpoints = Checkpoints(service.run_dir, settings, service.complain_once)
        self._map = MapKeeper(settings.tracker.map, origin_deg, service.run_dir, service.complain_once)
        self._vehicle: Vehicle | None = None
        self._seq = 0
        started_ns = clock.monotonic_ns()
        source: UtcSource = "clock" if clock.synchronized() else "unsure"
        self._utc = VehicleUtc(started_ns, clock.utc_offset_ns(), source)
        self._left_out = 0
        self._least_id = self._left_id = 1
        self._listed_ns = 0
        self._tracker: Tracker
        self._inputs: InputMonitor

    def start(self) -> None:
        """Go on where a tracker that was killed left off, and compile while the map is read."""
        self._take_over()
        self._look_after_map(clock.monotonic_ns())
        warm_up(self.settings.tracker)
        deadline_ns = clock.monotonic_ns() + round(MAP_WAIT_S * clock.NS)
        while self._map.to_be_read and (now_ns := clock.monotonic_ns()) < deadline_ns and not self._map.problem(now_ns):
            time.sleep(0.001)
            self._look_after_map(now_ns)

    def _take_over(self) -> None:
        """Make the tracker of what a former one left."""
        settings, now_ns = self.settings.tracker, clock.monotonic_ns()
        watches, why_ended = self.service.process.watches, partial(last_words.left, self.service.run_dir)
        left = self._checkpoints.read(now_ns, settings.resume_within_s)
        self._least_id = left.next_id or 1
        unknown = left.lost or (self._map.to_be_read and not left.same)
        first_id = provisional_first_id() if unknown else self._least_id
        self._tracker = Tracker(settings, first_id=first_id)
        self._inputs = InputMonitor(now_ns, watches, why_ended)
        mission = left.mission
        if mission is None:
            return
        try:
            self._tracker.restore(mission.tracker, left.known, first_id)
        except ValueError as error:
            self.service.complain_once("checkpoint_unusable", f"the tracker begins anew: {error}")
            self._tracker = Tracker(settings, first_id=first_id)
            return
        unwritten = set(mission.unwritten)
        self._map.note([o for o in left.known if o.id in unwritten], mission.undeleted)
        self._lister.restore(mission.announced)
        self._inputs = InputMonitor(now_ns, watches, why_ended, mission.first_ping_ns)
        self._ping_seq = mission.ping_seq
        self._utc = VehicleUtc(mission.started_ns, mission.utc_ahead_ns, self._utc.source)
        log.warning("goes on with the %d objects of a tracker that was killed", len(self._tracker.snapshot()))

    def _leave(self, now_ns: int) -> None:
        """Leave to a next tracker what it needs to go on."""
        tracker = self._tracker
        try:
            if self._checkpoints.base_due(tracker.map_changes()):
                self._checkpoints.write_base(tracker.whole_map())
            mission = Mission(
                tracker=tracker.state(),
                map_changes=tracker.map_changes(),
                announced=self._lister.state(),
                unwritten=self._map.pending.puts(),
                undeleted=self._map.pending.removes(),
                first_ping_ns=self._inputs.first_ping_ns,
                ping_seq=self._ping_seq,
                started_ns=self._utc.started_ns,
                utc_ahead_ns=self._utc.ahead_ns,
            )
            self._checkpoints.write(now_ns, tracker.next_id, mission)
        except OSError as error:
            self.service.complain_once("checkpoint_failed", f"objects would not outlive a kill: {error}")
        self._left_id = tracker.next_id

    def handle(self, topic: str, message: Any) -> None:
        """Take one message; detections wait for the end of the round, when all poses are in."""
        if topic == "pose":
            self._poses.insert(message)
            self._poses_until = message.seq
            self._inputs.pose(message.t_ns)
            self._utc.hear(message)
        elif topic == "detections":
            self._backlog.add(message, message.seq, message.t_ns)
        else:
            self._inputs.health(message)

    def tick(self) -> None:
        """Track the pings that came, or the newest if that is all there is time for; say so when none come.

        Look after the map.
        """
        self._follow_utc()
        self._work_off()
        now_ns = clock.monotonic_ns()
        period_ns = self.settings.tracker.planner.period_s * clock.NS
        if self._inputs.silent(now_ns) and now_ns - self._listed_ns >= period_ns:
            self._list(now_ns, None, self._poses.at(now_ns))
        self._look_after_map(now_ns)

    def problems(self) -> list[str]:
        """Say what is wrong with the map, and that the list is not complete; all else is in the list's own reasons."""
        map_problem = self._map.problem(clock.monotonic_ns())
        most = self.settings.tracker.planner.most_listed
        bounded = f"{self._left_out} objects are not listed: {most} others are nearer" if self._left_out else ""
        return [problem for problem in (map_problem, bounded) if problem]

    def stop(self) -> None:
        """Put what rests in view into the map too: the mission ends."""
        self._map.note(self._tracker.resting(self._utc.at(clock.monotonic_ns())), ())
        self._map.close(self._tracker.next_id)
        with contextlib.suppress(OSError):
            self._checkpoints.write(clock.monotonic_ns(), self._tracker.next_id, mission=None)

    def _follow_utc(self) -> None:
        moved = self._utc.follow(clock.monotonic_ns())
        if moved is not None:
            step_s = moved.step_ns / clock.NS
            self.service.complain_once("utc_steps", f"UTC steps by {step_s:+.1f} s: stamps since the start go with it")
            self._map.note(self._tracker.restamp(moved), ())

    def _work_off(self) -> None:
        scans, skipped = self._backlog.take()
        for _ in range(skipped):
            self.service.complain_once("skipped_pings", f"{self._backlog.slowness()}: not all are tracked")
        for scan in scans:
            began = clock.monotonic_ns()
            self._track(scan)
            self._backlog.worked(clock.monotonic_ns() - began)

    def _look_after_map(self, now_ns: int) -> None:
        known = self._map.poll(now_ns, self._tracker.next_id)
        if known is not None:
            first_id = None if known.first_id is None else max(known.first_id, self._least_id)
            self._tracker.join(known.objects, first_id)

    def _track(self, message: Detections) -> None:
        if message.t_ns > clock.monotonic_ns() + FUTURE_NS:
            self.service.complain_once("detections_from_future", f"ping {message.ping_number} is stamped in the future")
            return
        pose = self._poses.at(message.t_ns)
        sent, utc_ns = head_of(pose, self._mounting), self._utc.at(message.t_ns)
        scan, dropped, at_rest = received(message, sent, self._head_at, utc_ns, self._pings_between(message.seq))
        self.service.counters["pings_without_reception_pose"] += at_rest
        outcome = self._tracker.step(scan)
        if not outcome.taken:
            self.service.complain_once("detections_late", f"ping {message.ping_number} came after a later one")
            return
        self._vehicle = scan.vehicle or self._vehicle
        self._inputs.ping(message.t_ns)
        self._inputs.sight(message.t_ns, message.unseen_share, message.unseen_why)
        self.service.counters["echoes_bad"] += dropped
        self.service.counters["pings_without_pose"] += scan.vehicle is None
        if outcome.ended is not None:
            self._lister.end(outcome.ended)
        self._map.note(outcome.hibernated, [] if outcome.ended is None else outcome.ended.id.tolist())
        self._list(message.t_ns, message, pose)

    def _head_at(self, t_ns: int) -> PoseEstimate | None:
        return head_of(self._poses.at(t_ns), self._mounting)

    def _pings_between(self, seq: int) -> int:
        """Return how many pings there were, since the last one tracked, whose images nobody looked at."""
        last, self._ping_seq = self._ping_seq, seq
        return 0 if last is None else max(0, seq - last - 1)

    def _list(self, t_ns: int, shown: Detections | None, pose: PoseEstimate | None) -> None:
        """Publish the list for the instant `t_ns`; `pose`: the vehicle's then; `shown`: what the ping did, if any."""
        now_ns = clock.monotonic_ns()
        reasons = self._inputs.reasons(now_ns, pose_known=pose is not None or shown is None)
        course = None if pose is None else Course(pose.position_ned, pose.velocity_ned)
        bottom, everything = bottom_below(pose), self._snapshot(t_ns)
        hittable = everything.take(may_be_hit(everything, bottom, self.settings.tracker.bottom))
        centre = None if self._vehicle is None else self._vehicle.position
        nearest = hittable.nearest(self.settings.tracker.planner.most_listed, centre)
        self._left_out = len(hittable) - len(nearest)
        message = ObstacleList(
            seq=self._seq,
            ping_number=-1 if shown is None else shown.ping_number,
            t_ns=t_ns,
            utc_ns=self._utc.at(t_ns),
            t_rx_ns=0 if shown is None else shown.t_rx_ns,
            valid=not reasons,
            reasons=reasons,
            obstacles=self._lister.obstacles(nearest, course, bottom),
            utc_source=self._utc.source,
            left_out=self._left_out,
            bottom_left_out=len(everything) - len(hittable),
            unseen=[] if shown is None else shown.unseen,
            unseen_share=0.0 if shown is None else shown.unseen_share,
            unseen_why="" if shown is None else shown.unseen_why,
            poses_until=self._poses_until,
            made_ns=now_ns,
        )
        if self._tracker.next_id != self._left_id:
            self._leave(now_ns)  # or an id might be heard of and then be given again
            self.service.publish("obstacles", message)
        else:
            self.service.publish("obstacles", message)
            self._leave(now_ns)
        self._seq += 1
        self._listed_ns = now_ns

    def _snapshot(self, t_ns: int) -> Snapshot:
        within = None
        if self._vehicle is not None:
            within = (self._vehicle.position, self.settings.tracker.planner.hibernated_within_m)
        snapshot = self._tracker.snapshot(within)
        newest_ns = self._tracker.t_ns
        if newest_ns is None:
            return snapshot
        return snapshot.carried_on(max(0, t_ns - newest_ns) / clock.NS, self.settings.tracker.motion)
