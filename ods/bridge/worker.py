"""Common work of all bridges: it sends the newest one, if it is valid and it is time.

A receiver that receives nothing lets its obstacles expire, which is what it shall do when the list cannot be relied on.
"""

from abc import abstractmethod
from typing import Any, ClassVar, TypeVar

from ods.base import clock
from ods.bridge.extrapolated_list import ExtrapolatedList, is_finite
from ods.bridge.settings import BridgeConfig, ListSettings
from ods.messages import ObstacleList
from ods.runtime import bus
from ods.runtime.service import Service, StartError, Worker

STALE_NS = round(bus.TOPICS["obstacles"].stale_s * clock.NS)

TableT = TypeVar("TableT", bound=ListSettings)


class ListWorker(Worker[BridgeConfig]):
    """Keeps the newest list, and says why it is not sent.

    Counters: withheld_lists, paced_lists.
    """

    name: ClassVar[str]
    """Of its table."""
    needs: ClassVar[str] = ""
    """What a table must say at least."""

    def __init__(self, service: Service, settings: BridgeConfig) -> None:
        super().__init__(service, settings)
        self._obstacle_list: ObstacleList | None = None
        self._received_ns = clock.monotonic_ns()
        self._due_ns = 0
        self._silent = ""
        """Why the last list was not sent."""
        if getattr(settings.bridge, self.name) is None:
            raise StartError(f"bridge.{self.name}: missing{self.needs}")
        self._period_ns = round(clock.NS / self.table(ListSettings).most_hz)

    def table(self, kind: type[TableT]) -> TableT:
        """Return the settings of this bridge."""
        found = getattr(self.settings.bridge, self.name)
        assert isinstance(found, kind)
        return found

    def handle(self, topic: str, message: Any) -> None:
        """Keep the newest list; what waits for its turn is never older than that."""
        self._received_ns = clock.monotonic_ns()
        if self._obstacle_list is not None:
            self.service.counters["paced_lists"] += 1
        self._obstacle_list = message

    def tick(self) -> None:
        """Send the newest list, if it is time."""
        now_ns = clock.monotonic_ns()
        if self._obstacle_list is None or now_ns < self._due_ns:
            return
        obstacle_list, self._obstacle_list = self._obstacle_list, None
        self._silent = why_silent(obstacle_list, now_ns)
        self.judged(obstacle_list, self._silent)
        if self._silent or obstacle_list.pose is None:
            self.service.log_once("withheld_lists", f"nothing is sent: {self._silent}")
            return
        self._due_ns = now_ns + self._period_ns
        self.send(ExtrapolatedList(obstacle_list, obstacle_list.pose, now_ns))

    def judged(self, obstacle_list: ObstacleList, silent: str) -> None:
        """Record a list, and why it is not sent."""

    @abstractmethod
    def send(self, extrapolated: ExtrapolatedList) -> None:
        """Send a list that is valid."""

    @abstractmethod
    def peer_problem(self, now_ns: int) -> str:
        """Return what is wrong with the receiver or the way there, or ""."""

    def silence(self, now_ns: int) -> str:
        """Return why nothing is sent, or ""."""
        silent_ns = now_ns - self._received_ns
        return f"no obstacle list for {silent_ns / clock.NS:.1f} s" if silent_ns > STALE_NS else self._silent

    def problems(self) -> list[str]:
        """Return why nothing is sent, and that the receiver takes no data, a text each."""
        now_ns = clock.monotonic_ns()
        silent = self.silence(now_ns)
        return [said for said in (f"nothing is sent: {silent}" if silent else "", self.peer_problem(now_ns)) if said]


def why_silent(obstacle_list: ObstacleList, now_ns: int) -> str:
    """Return why a list must not be sent, or ""."""
    if not obstacle_list.valid:
        return "the list is not valid: " + "; ".join(obstacle_list.reasons)
    age_ns = now_ns - (obstacle_list.made_ns or obstacle_list.t_ns)
    if age_ns > STALE_NS:
        return f"the list is {age_ns / clock.NS:.1f} s old"
    if obstacle_list.pose is None or not is_finite(obstacle_list.pose):
        return "the vehicle's pose is not known"
    return ""
