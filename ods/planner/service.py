"""The planner process: obstacle list and clearance to set points. On the bench, never on board."""

from ods.base import clock
from ods.messages import Clearance, ObstacleList, VehicleSetPoint
from ods.planner.can_sender import CanSender
from ods.planner.planner import Planner, SetPoint
from ods.planner.settings import PlannerConfig
from ods.runtime.service import Service, StartError, Worker

PERIOD_NS = round(0.2 * clock.NS)
"""Longest period of set points, ns; one is also sent at each list."""


class PlannerWorker(Worker[PlannerConfig]):
    """Steers by the newest list and the newest clearance, and no other message.

    Before the first list with a pose it is silent, as it does not know where it is; and once it has arrived, on CAN:
    the vehicle then stops by its own watchdog. Counters: set_points, not_valid, and those of `CanSender`.
    """

    def __init__(self, service: Service, settings: PlannerConfig) -> None:
        super().__init__(service, settings)
        if settings.planner is None:
            raise StartError("planner: missing: set `way_points`, the vehicle's route")
        wanted = settings.planner
        self._planner = Planner(wanted.steering, wanted.way_points)
        self._stale_ns = round(wanted.steering.stale_s * clock.NS)
        self._can = CanSender(wanted.can, service.counters) if wanted.can is not None else None
        self._list: ObstacleList | None = None
        """The newest one with a pose."""
        self._clearance: Clearance | None = None
        self._is_new = False
        self._due_ns = 0
        self._seq = 0
        self._valid = True
        """The newest list is; the tracker's health says why not."""
        self._received_ns = clock.monotonic_ns()
        self._newest: SetPoint | None = None

    def handle(self, topic: str, message: ObstacleList | Clearance) -> None:
        """Keep the newest of both."""
        if isinstance(message, Clearance):
            self._clearance = message
            return
        self._received_ns = clock.monotonic_ns()
        self._valid = message.valid
        if message.pose is not None:
            self._list, self._is_new = message, True

    def tick(self) -> None:
        """Steer, if there is a new list or it is time."""
        now_ns = clock.monotonic_ns()
        if self._list is None or not (self._is_new or now_ns >= self._due_ns):
            return
        if self._is_new:
            self._planner.receive(self._list, self._fresh(now_ns))
        self._is_new, self._due_ns = False, now_ns + PERIOD_NS
        self._newest = self._planner.steer(now_ns)
        self._tell(self._newest, now_ns, self._list.seq)

    def _fresh(self, now_ns: int) -> Clearance | None:
        known = self._clearance
        return None if known is None or now_ns - known.t_ns > self._stale_ns else known

    def _tell(self, wanted: SetPoint, now_ns: int, list_seq: int) -> None:
        if self._can is not None and not wanted.arrived:
            self._can.send(wanted.heading_rad, wanted.speed_m_s, wanted.down_m)
        self.service.publish(
            "set-point",
            VehicleSetPoint(
                seq=self._seq,
                t_ns=now_ns,
                utc_ns=clock.utc_ns(now_ns),
                heading_rad=wanted.heading_rad,
                speed_m_s=wanted.speed_m_s,
                down_m=wanted.down_m,
                list_seq=list_seq,
                avoiding=wanted.avoiding,
                valid=wanted.valid,
                arrived=wanted.arrived,
            ),
        )
        self._seq += 1
        self.service.counters["set_points"] += 1
        self.service.counters["not_valid"] += not wanted.valid

    def problems(self) -> list[str]:
        """Return why there is no valid list to steer by, and the problems of CAN, a text each."""
        found = []
        silent_ns = clock.monotonic_ns() - self._received_ns
        if silent_ns > self._stale_ns:
            found.append(f"no obstacle list for {silent_ns / clock.NS:.1f} s")
        elif self._list is None:
            found.append("the vehicle's pose is not known")
        elif not self._valid:
            found.append("the list is not valid")
        if self._can is not None and self._can.problem:
            found.append(f"CAN: {self._can.problem}")
        return found

    def stop(self) -> None:
        """Give the CAN interface back."""
        if self._can is not None:
            self._can.close()
