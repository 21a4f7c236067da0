"""The tracker process: detections and poses from the bus, obstacle lists to the planner, the map on disk."""

import contextlib
import logging
import time
from functools import partial
from typing import Any

from ods.base import clock
from ods.base.errors import reason_of
from ods.messages import Detections, ObstacleList, VetoAnswer, VetoOrder
from ods.pose.utc import VehicleUtc
from ods.runtime.backlog import Backlog
from ods.runtime.service import Service, Worker
from ods.runtime.state_files import exit_reason
from ods.tracker.clearance.clearance import ClearanceKeeper
from ods.tracker.map.keeper import WAIT_S, MapKeeper
from ods.tracker.mission import MissionTracker
from ods.tracker.output.validity import InputMonitor
from ods.tracker.restart.checkpoint import Checkpoints
from ods.tracker.restart.ids import first_of, provisional_first_id, reserved_id
from ods.tracker.settings import TrackerConfig, TrackerProcessConfig
from ods.tracker.veto.operators import Asked, Operators, in_words
from ods.tracker.veto.vetoes import RefusedError
from ods.tracker.warm_up import warm_up

log = logging.getLogger(__name__)

OVERLOADED_WAIT_S = 20.0
"""Time for which the first list waits for the map to be read, s, where the computer is overloaded, and else `WAIT_S`; a
disk that takes longer costs its objects, and their ids, until it is there."""


class TrackerWorker(Worker[TrackerProcessConfig]):
    """Runs the tracker over what the bus brings."""

    def __init__(self, service: Service, settings: TrackerProcessConfig) -> None:
        super().__init__(service, settings)
        self._backlog: Backlog[Detections] = Backlog()
        origin_deg = settings.site.latitude_deg, settings.site.longitude_deg
        makes_it = TrackerConfig(
            site=settings.site, pose=settings.pose, tracker=settings.tracker, mounting=settings.mounting
        )
        self._checkpoints = Checkpoints(service.run_dir, makes_it, service.log_once)
        self._map = MapKeeper(settings.tracker.map, origin_deg, service.run_dir, service.log_once)
        self._least_id = 1
        self._listed: set[int] = set()
        """Ids of the last list."""
        self._mission: MissionTracker
        self._clearance = ClearanceKeeper(settings.tracker.clearance)
        self._operators = Operators(settings.bus.keys, service.run_dir)
        self._orders = 0

    def start(self) -> None:
        """Continue from the checkpoint of a killed tracker, and warm up while the map is read."""
        self._take_over()
        self._look_after_map(clock.monotonic_ns())
        warm_up(self.settings.tracker)
        begun_ns = clock.monotonic_ns()
        while self._map.to_be_read and self._may_wait_for_map(begun_ns):
            time.sleep(0.001)
            self._look_after_map(clock.monotonic_ns())

    def _may_wait_for_map(self, begun_ns: int) -> bool:
        now_ns = clock.monotonic_ns()
        waited_s = (now_ns - begun_ns) / clock.NS
        if waited_s < WAIT_S:
            return not self._map.problem(now_ns)
        return waited_s < OVERLOADED_WAIT_S and bool(self.service.overload())

    def _take_over(self) -> None:
        """Make the tracker of what a former one left."""
        left = self._checkpoints.read(clock.monotonic_ns(), self.settings.tracker.resume_within_s)
        self._least_id = left.next_id or 1
        unknown = left.lost or (self._map.to_be_read and not left.same)
        first_id = provisional_first_id() if unknown else self._least_id
        self._mission = self._new_mission(first_id)
        mission = left.mission
        if mission is None:
            return
        try:
            self._mission.restore(mission, left.known, first_id)
        except ValueError as error:
            self.service.log_once("checkpoint_unusable", f"starting without a checkpoint: {error}")
            self._mission = self._new_mission(first_id)
            return
        unwritten = set(mission.unwritten)
        self._map.note([o for o in left.known if o.id in unwritten], mission.undeleted)
        count = len(self._mission.tracker.snapshot())
        log.warning("restored %d objects from the checkpoint of the tracker that was killed", count)

    def _new_mission(self, first_id: int) -> MissionTracker:
        service, now_ns = self.service, clock.monotonic_ns()
        why_ended = partial(exit_reason.read, service.run_dir)
        return MissionTracker(
            self.settings,
            InputMonitor(now_ns, service.process.watches, why_ended, service.overload),
            VehicleUtc(now_ns, clock.utc_offset_ns(), "clock" if clock.synchronized() else "unsure"),
            first_id=first_id,
            counters=service.counters,
            complain=service.log_once,
        )

    def _leave(self, now_ns: int) -> None:
        """Write the checkpoint for a next tracker."""
        tracker, pending = self._mission.tracker, self._map.pending
        try:
            if self._checkpoints.base_due(tracker.map_changes()):
                self._checkpoints.write_base(tracker.whole_map())
            mission = self._mission.state(list(pending.puts), list(pending.removes))
            self._checkpoints.write(now_ns, reserved_id(tracker.next_id), mission)
        except OSError as error:
            reason = f"objects would be lost if the tracker were killed: {reason_of(error)}"
            self.service.log_once("checkpoint_failed", reason)

    def handle(self, topic: str, message: Any) -> None:
        """Take one message; detections wait for the end of the round, when all poses are in."""
        if topic == "pose":
            self._mission.add_pose(message, clock.monotonic_ns())
        elif topic == "detections":
            self._backlog.add(message, message.seq, message.t_ns)
        else:
            self._mission.add_health(message)

    def tick(self) -> None:
        """Track the pings that came, or the newest if that is all there is time for; say so when none come.

        Look after the map.
        """
        self._map.note(self._mission.follow_utc(clock.monotonic_ns()), ())
        self._work_off()
        now_ns = clock.monotonic_ns()
        for asked in self._operators.asked():
            self._follow(asked, now_ns)
        if self._mission.silent_list_due(now_ns):
            self._publish(self._mission.silent_list(now_ns), None, now_ns)
        self._note_operators()
        self._look_after_map(now_ns)

    def problems(self) -> list[str]:
        """Return what is wrong with the map and the velocities, and that the list is not complete.

        All else is in the list's own reasons.
        """
        map_problem = self._map.problem(clock.monotonic_ns())
        most, left_out = self.settings.tracker.planner.most_listed, self._mission.left_out
        bounded = f"{left_out} objects are not listed: {most} nearer ones fill the list" if left_out else ""
        found = map_problem, bounded, self._operators.problem
        return [problem for problem in found if problem] + self._mission.problems()

    def stop(self) -> None:
        """Put what rests in view into the map too: the mission ends."""
        self._operators.close()
        next_id = self._mission.tracker.next_id
        self._map.note(self._mission.resting(clock.monotonic_ns()), ())
        self._map.close(next_id)
        with contextlib.suppress(OSError):
            self._checkpoints.write(clock.monotonic_ns(), next_id, mission=None)

    def _follow(self, asked: Asked, now_ns: int) -> None:
        """Carry out an operator's request, or refuse it; report that on the bus and in the log."""
        request, refused = asked.request, ""
        try:
            self._map.note((), self._mission.follow(request, asked.author, now_ns))
        except RefusedError as error:
            refused = str(error)
            self.service.counters["vetoes_refused"] += 1
        if request.do != "list":
            order = VetoOrder(
                seq=self._orders,
                t_ns=now_ns,
                utc_ns=clock.utc_ns(now_ns),
                author=asked.author,
                request=request,
                refused=refused,
            )
            self._orders += 1
            self.service.counters["veto_orders"] += 1
            self.service.publish("veto-orders", order)
            log.warning("%s", in_words(order))
            self._leave(now_ns)  # or a next tracker would not know
        vetoes = self._mission.vetoes_held(now_ns)
        self._operators.answer(asked, VetoAnswer(ok=not refused, reason=refused, vetoes=vetoes))

    def _note_operators(self) -> None:
        """Take over what the operators' socket counts, and report which vetoes have ended."""
        for name, count in self._operators.counters.items():
            self.service.counters[name] = count
        ended, self._mission.vetoes.ended = self._mission.vetoes.ended, []
        for line in ended:
            self.service.counters["vetoes_over"] += 1
            log.warning("%s", line)

    def _work_off(self) -> None:
        scans, skipped = self._backlog.take()
        for _ in range(skipped):
            why = self.service.overload() or self._backlog.slowness()
            self.service.log_once("skipped_pings", f"{why}: some are skipped")
        for scan in scans:
            began = clock.monotonic_ns()
            self._track(scan)
            self._backlog.worked(clock.monotonic_ns() - began)

    def _track(self, scan: Detections) -> None:
        now_ns = clock.monotonic_ns()
        tracked = self._mission.track(scan, now_ns)
        if tracked is not None:
            self._map.note(tracked.hibernated, tracked.gone)
            self._publish(tracked.message, scan, now_ns)

    def _look_after_map(self, now_ns: int) -> None:
        known = self._map.poll(now_ns, self._mission.tracker.next_id)
        if known is not None:
            first_id = None if known.first_id is None else first_of(known.first_id, self._least_id)
            self._mission.tracker.join(known.objects, first_id)

    def _publish(self, message: ObstacleList, scan: Detections | None, now_ns: int) -> None:
        listed = {o.id for o in message.obstacles}
        if listed <= self._listed:
            self.service.publish("obstacles", message)
            self._leave(now_ns)
        else:
            self._leave(now_ns)  # or an object might be listed that a next tracker does not know
            self.service.publish("obstacles", message)
        self._listed = listed
        self.service.publish("clearance", self._clearance.after(message, scan))
