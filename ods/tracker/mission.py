"""The tracker from messages to obstacle lists, without sockets, files or a clock of its own.

The process (`service`), files (`ods track`) and recordings (`ods replay`) give it the same messages and the time.
"""

from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

import msgspec

from ods.base import clock
from ods.base.frames.mounting import Mounting
from ods.messages import Detections, Health, Obstacle, ObstacleList, Pose, PoseAt, Site, Veto, VetoRequest
from ods.pose.buffer import PoseBuffer, PoseEstimate
from ods.pose.head import head_of
from ods.pose.utc import VehicleUtc
from ods.tracker.common_error.monitor import CommonErrors
from ods.tracker.common_error.sightings import Motion
from ods.tracker.map.map_object import MapObject
from ods.tracker.measurement.from_detections import received
from ods.tracker.measurement.scan import Vehicle
from ods.tracker.outline.outlines import Outlines
from ods.tracker.outline.seen import seen_from
from ods.tracker.output.bottom import bottom_below
from ods.tracker.output.closest_approach import Course
from ods.tracker.output.hittable import ReportableFilter
from ods.tracker.output.multipath import marked
from ods.tracker.output.obstacle_list import ObstacleLister
from ods.tracker.output.pose_sense import PoseSense
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.output.surface import View
from ods.tracker.output.validity import InputMonitor
from ods.tracker.restart.checkpoint import MissionState
from ods.tracker.settings import TrackerConfig
from ods.tracker.tracker import Tracker
from ods.tracker.veto.vetoes import RefusedError, Vetoes

FUTURE_NS = clock.NS
"""A ping, or a pose, stamped later than now by more than this has a wrong time."""

SLOWEST = 1400.0
"""Sound speed, m/s, where it is not reported."""

Complain = Callable[[str, str], None]
"""Takes a counter's name and a line: each loss is counted, the first one is logged."""


class TrackedPing(NamedTuple):
    """Results of one ping."""

    message: ObstacleList
    hibernated: list[MapObject]
    """Objects that belong in the map from now on."""
    gone: list[int]
    """Ids of objects that no longer do."""


class MissionTracker:
    """The tracker of one mission with all that surrounds it: poses, reception, list, validity, UTC.

    `counters`: pings_without_pose, pings_without_reception_pose, echoes_bad, those of the pose buffer and of the
    lister; `complain`: detections_from_future, detections_late, poses_from_future, pose_jumps, utc_steps.
    """

    def __init__(
        self,
        settings: TrackerConfig,
        inputs: InputMonitor,
        utc: VehicleUtc,
        *,
        first_id: int = 1,
        counters: "Counter[str] | None" = None,
        complain: Complain | None = None,
    ) -> None:
        """New objects get ids from `first_id` on. Raises PluginError."""
        self.settings = settings.tracker
        self.counters: Counter[str] = Counter() if counters is None else counters
        self._complain = self._count if complain is None else complain
        self.tracker = Tracker(self.settings, first_id=first_id)
        self._site = Site(settings.site.latitude_deg, settings.site.longitude_deg)
        self._mounting = Mounting(settings.mounting)
        self._poses = PoseBuffer(*msgspec.structs.astuple(settings.pose))
        self._pose_sense = PoseSense()
        self._common_errors = CommonErrors()
        self._jumps_ns: list[int] = []
        """Of the pose, behind the newest ping."""
        self._poses_until, self._poses_heard = -1, 0
        self._lister = ObstacleLister(self.settings.planner, self.settings.motion, self.settings.bottom)
        self._hittable = ReportableFilter(self.settings)
        self._outlines = Outlines()
        self.vetoes = Vetoes()
        self._present: list[Obstacle] = []
        """Of the newest list."""
        self._poses.counters = self._lister.counters = self.counters
        self._inputs = inputs
        self._utc = utc
        self._vehicle: Vehicle | None = None
        self._half_vertical = 0.0
        """Of the newest ping's fan, rad."""
        self._ping_seq: int | None = None
        self.seq = 0
        """Of the next list."""
        self._listed_ns = 0
        self.left_out = 0
        """Objects that the newest list had no room for."""

    def _count(self, name: str, _: str) -> None:
        self.counters[name] += 1

    def restore(self, mission: MissionState, known: list[MapObject], first_id: int) -> None:
        """Restore the state of a former tracker. Raises ValueError for an invalid state; this one is unusable then."""
        self.tracker.restore(mission.tracker, known, first_id)
        self._lister.restore(mission.announced)
        self.vetoes = Vetoes(mission.vetoes)
        self._inputs.first_ping_ns, self._inputs.looked_ns = mission.first_ping_ns, mission.looked_ns
        self._ping_seq = mission.ping_seq
        self._utc = VehicleUtc(mission.started_ns, mission.utc_ahead_ns, self._utc.source)

    def state(self, unwritten: list[int], undeleted: list[int]) -> MissionState:
        """Return where it is in its work; `unwritten`, `undeleted`: ids that the map's file is behind with."""
        return MissionState(
            tracker=self.tracker.state(),
            map_changes=self.tracker.map_changes(),
            announced=self._lister.state(),
            unwritten=unwritten,
            undeleted=undeleted,
            first_ping_ns=self._inputs.first_ping_ns,
            looked_ns=self._inputs.looked_ns,
            ping_seq=self._ping_seq,
            started_ns=self._utc.started_ns,
            utc_ahead_ns=self._utc.ahead_ns,
            vetoes=self.vetoes.state(),
        )

    def add_pose(self, pose: Pose, now_ns: int | None = None) -> None:
        """Take in a pose. One later than `now_ns`, where that is given, is dropped: it would exclude all others for
        long."""
        if now_ns is not None and pose.t_ns > now_ns + FUTURE_NS:
            self._complain("poses_from_future", f"pose {pose.seq} is stamped in the future")
            return
        self._poses.insert(pose)
        jump = self._pose_sense.receive(pose)
        if jump:
            self._complain("pose_jumps", jump)
            self._jumps_ns.append(pose.t_ns)
        self._poses_until = pose.seq
        self._poses_heard += 1
        self._inputs.pose(pose.t_ns)
        self._utc.receive(pose)

    def problems(self) -> list[str]:
        """Return the problems besides the reasons why a list is not valid, a text each."""
        return [each for each in (self._pose_sense.disagreement, self._common_errors.problem()) if each]

    def add_health(self, health: Health) -> None:
        """Take in what a process says of itself."""
        self._inputs.health(health)

    def follow_utc(self, now_ns: int) -> list[MapObject]:
        """Follow the UTC of the poses; return the objects of the map that this restamps."""
        moved = self._utc.follow(now_ns)
        if moved is None:
            return []
        step_s = moved.step_ns / clock.NS
        self._complain("utc_steps", f"UTC steps by {step_s:+.1f} s: stamps since the start are corrected")
        return self.tracker.restamp(moved)

    def track(self, message: Detections, now_ns: int) -> TrackedPing | None:
        """Take in the detections of a ping; None: they came late, or from the future."""
        if message.t_ns > now_ns + FUTURE_NS:
            self._complain("detections_from_future", f"ping {message.ping_number} is stamped in the future")
            return None
        if message.t_ns == self.tracker.t_ns:  # the same ping twice would count as two scans
            self._complain("detections_late", f"ping {message.ping_number} has the same time as the previous one")
            return None
        pose = None if self._jumps_within(message) else self._poses.at(message.t_ns)
        sent, utc_ns = head_of(pose, self._mounting), self._utc.at(message.t_ns)
        scan, dropped, at_rest = received(message, sent, self._head_at, utc_ns, self._pings_between(message.seq))
        self.counters["pings_without_reception_pose"] += at_rest
        outcome = self.tracker.step(scan)
        if not outcome.taken:
            self._complain("detections_late", f"ping {message.ping_number} came after a later one")
            return None
        self._vehicle = scan.vehicle or self._vehicle
        snapshot = self._snapshot(message.t_ns)
        if sent is not None:
            motion = Motion(sent.velocity_ned[:2], 0.5 * scan.fan_turn * message.sound_speed)
            self._common_errors.look(snapshot, scan, motion)
            seen = seen_from(sent, message.detections, scan.fan_turn, message.sound_speed)
            self._outlines.look(snapshot, seen, sent, utc_ns)
        self._half_vertical = message.sector.half_vertical_rad
        self._inputs.ping(message.t_ns, message.turn_s)
        self._inputs.observed(
            message.t_ns, message.unseen_share, message.unseen_why, pose_known=scan.vehicle is not None
        )
        self.counters["echoes_bad"] += dropped
        self.counters["pings_without_pose"] += scan.vehicle is None
        if outcome.ended is not None:
            self._lister.end(outcome.ended)
        gone = [] if outcome.ended is None else outcome.ended.id.tolist()
        return TrackedPing(self._list(now_ns, message, pose, snapshot), outcome.hibernated, gone)

    def _jumps_within(self, message: Detections) -> bool:
        """Return whether the pose jumped while the ping's echoes came in; start again if it did before.

        What was tracked before a jump would be ghosts after it, beside the same objects at their new places.
        """
        passed = [t_ns for t_ns in self._jumps_ns if t_ns <= message.t_ns]
        if passed:
            self._lister.end(self.tracker.begin_again())
            self.vetoes.end_all("the pose jumped")
            self._common_errors.begin_again()
            self._inputs.begin_again(message.t_ns, "the pose jumped")
        self._jumps_ns = self._jumps_ns[len(passed) :]
        speed = message.sound_speed or SLOWEST
        received_ns = message.t_ns + round(2.0 * message.sector.range_max_m / speed * clock.NS)
        return any(t_ns <= received_ns for t_ns in self._jumps_ns)

    def follow(self, request: VetoRequest, author: str, now_ns: int) -> list[int]:
        """Carry out an operator's request; return the ids of objects that do not belong in the map any more.

        Raises RefusedError.
        """
        if request.do == "ignore":
            self.vetoes.ignore(request, author, self._present, now_ns)
        elif request.do == "restore":
            self.vetoes.restore(request)
        elif request.do == "forget" and request.id is not None:
            forgotten = self.tracker.forget(request.id)
            if forgotten is None:
                raise RefusedError(f"no obstacle {request.id}")
            self._lister.end(forgotten)
            self._common_errors.forget(request.id)
            self._present = [each for each in self._present if each.id != request.id]
            return [request.id]
        return []

    def vetoes_held(self, now_ns: int) -> list[Veto]:
        """Return the vetoes that hold."""
        return self.vetoes.held(now_ns, self._utc.at)

    def silent_list_due(self, now_ns: int) -> bool:
        """Return whether a list without a ping is due, as none came."""
        period_ns = self.settings.planner.period_s * clock.NS
        return self._inputs.silent(now_ns) and now_ns - self._listed_ns >= period_ns

    def silent_list(self, now_ns: int) -> ObstacleList:
        """Return a list of the moment, without a ping."""
        return self._list(now_ns, None, self._poses.at(now_ns), self._snapshot(now_ns))

    def resting(self, now_ns: int) -> list[MapObject]:
        """Return what rests in view, as objects of the map: for the end of the mission."""
        return self.tracker.resting(self._utc.at(now_ns))

    def _head_at(self, t_ns: int) -> PoseEstimate | None:
        return head_of(self._poses.at(t_ns), self._mounting)

    def _pings_between(self, seq: int) -> int:
        """Return the number of pings since the last one tracked whose images were not processed."""
        last, self._ping_seq = self._ping_seq, seq
        return 0 if last is None else max(0, seq - last - 1)

    def _list(
        self, now_ns: int, shown: Detections | None, pose: PoseEstimate | None, snapshot: Snapshot
    ) -> ObstacleList:
        """Return the list of a ping, or of now; shown: what the ping did; the vehicle's pose; and all objects."""
        t_ns = now_ns if shown is None else shown.t_ns
        reasons = self._inputs.reasons(now_ns, pose_known=pose is not None or shown is None)
        reasons += self._pose_sense.reasons(now_ns)
        course = None if pose is None else Course(pose.position_ned, pose.velocity_ned)
        bottom, head = bottom_below(pose), head_of(pose, self._mounting)
        caution = "" if shown is None else shown.caution
        reasons += self._common_errors.reasons(convoy=not self._pose_sense.is_doubtful, caution=caution)
        view = None if head is None else View(self._utc.at(t_ns), head, self._half_vertical)
        hittable = self._hittable.of(self._common_errors.widened(snapshot), bottom, view)
        centre = None if self._vehicle is None else self._vehicle.position
        nearest = self._outlines.covering(hittable.nearest(self.settings.planner.most_listed, centre))
        self.left_out = len(hittable) - len(nearest)
        obstacles = self._outlines.outlined(self._lister.obstacles(nearest, course, bottom), t_ns)
        if shown is not None and head is not None:
            obstacles = marked(obstacles, head.position_ned, shown.second_ways_m)
        self._present = self.vetoes.marked(obstacles, now_ns)
        message = ObstacleList(
            seq=self.seq,
            ping_number=-1,
            t_ns=t_ns,
            utc_ns=self._utc.at(t_ns),
            t_rx_ns=0,
            valid=not reasons,
            reasons=reasons,
            obstacles=self._present,
            utc_source=self._utc.source,
            left_out=self.left_out,
            bottom_left_out=len(snapshot) - len(hittable),
            poses_until=self._poses_until,
            poses_heard=self._poses_heard,
            made_ns=now_ns,
            made_utc_ns=self._utc.at(now_ns),
            site=self._site,
            pose=_pose_at(pose),
            head=_pose_at(head),
            vetoes=self.vetoes_held(now_ns),
        )
        self.seq += 1
        self._listed_ns = now_ns
        return message if shown is None else _of_ping(message, shown)

    def _snapshot(self, t_ns: int) -> Snapshot:
        within = None
        if self._vehicle is not None:
            within = (self._vehicle.position, self.settings.planner.hibernated_within_m)
        snapshot = self.tracker.snapshot(within)
        newest_ns = self.tracker.t_ns
        if newest_ns is None or t_ns <= newest_ns:
            return snapshot
        return snapshot.extrapolated((t_ns - newest_ns) / clock.NS, self.settings.motion)


def _of_ping(message: ObstacleList, shown: Detections) -> ObstacleList:
    """Return a list with what its ping did."""
    return msgspec.structs.replace(
        message,
        ping_number=shown.ping_number,
        t_rx_ns=shown.t_rx_ns,
        unseen=shown.unseen,
        unseen_share=shown.unseen_share,
        unseen_why=shown.unseen_why,
        heard_from_db=shown.heard_from_db,
        caution=shown.caution,
        sector=shown.sector,
        processed_ranges_m=shown.processed_ranges_m,
    )


def _pose_at(estimate: PoseEstimate | None) -> PoseAt | None:
    """Return an estimate as messages have it."""
    if estimate is None:
        return None
    north, east, down = estimate.position_ned.tolist()
    w, x, y, z = estimate.attitude.tolist()
    v_north, v_east, v_down = estimate.velocity_ned.tolist()
    sigma_north, sigma_east, sigma_down = estimate.sigma_position.tolist()
    roll, pitch, yaw = estimate.sigma_attitude.tolist()
    return PoseAt(
        position_ned=(north, east, down),
        attitude=(w, x, y, z),
        velocity_ned=(v_north, v_east, v_down),
        sigma_position=(sigma_north, sigma_east, sigma_down),
        sigma_attitude=(roll, pitch, yaw),
        extrapolated_s=estimate.extrapolated_s,
    )
