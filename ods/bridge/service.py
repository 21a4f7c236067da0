"""The bridges' processes: obstacle lists to somebody else's planner. What is not valid is not sent.

A receiver that hears nothing lets its obstacles expire, which is what it shall do when the list cannot be relied on.
"""

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar, TypeVar

from ods.base import clock
from ods.bridge.encoder import Encoder
from ods.bridge.json_udp import JsonEncoder
from ods.bridge.moment import Moment, is_finite
from ods.bridge.moos import MoosEncoder
from ods.bridge.settings import (
    BridgeConfig,
    JsonSettings,
    MavlinkSettings,
    MoosSettings,
    TtmSettings,
    UdpSettings,
    destination_of,
)
from ods.bridge.ttm import TtmEncoder
from ods.bridge.udp_sender import UdpSender
from ods.messages import Clearance, ObstacleList
from ods.runtime import bus
from ods.runtime.service import Service, StartError, Worker

if TYPE_CHECKING:
    from ods.bridge.mavlink import MavlinkEncoder

STALE_NS = round(bus.TOPICS["obstacles"].stale_s * clock.NS)

TableT = TypeVar("TableT", bound=UdpSettings)


class BridgeWorker(Worker[BridgeConfig]):
    """Sends the newest list, if it is valid and it is time.

    Counters: sent_lists, sent_datagrams, withheld_lists, paced_lists, left_out_obstacles, and those of `UdpSender`.
    """

    name: ClassVar[str]
    """Of its table."""

    def __init__(self, service: Service, settings: BridgeConfig) -> None:
        super().__init__(service, settings)
        self._picture: ObstacleList | None = None
        self._heard_ns = clock.monotonic_ns()
        self._due_ns = 0
        self._silent = ""
        """Why the last list was not sent."""
        table = getattr(settings.bridge, self.name)
        if table is None:
            raise StartError(f"bridge.{self.name}: missing: `to` says where to send")
        self._period_ns = round(clock.NS / table.most_hz)
        self._sender = UdpSender(destination_of(table.to), service.complain_once)
        self._encoder = self.encoder()

    @abstractmethod
    def encoder(self) -> Encoder:
        """Return what turns lists into datagrams."""

    def table(self, kind: type[TableT]) -> TableT:
        """Return the settings of this bridge."""
        found = getattr(self.settings.bridge, self.name)
        assert isinstance(found, kind)
        return found

    def handle(self, topic: str, message: ObstacleList | Clearance) -> None:
        """Keep the newest list; what waits for its turn is never older than that."""
        assert isinstance(message, ObstacleList)
        self._heard_ns = clock.monotonic_ns()
        if self._picture is not None:
            self.service.counters["paced_lists"] += 1
        self._picture = message

    def tick(self) -> None:
        """Send the newest list, if it is time."""
        now_ns = clock.monotonic_ns()
        if self._picture is None or now_ns < self._due_ns:
            return
        picture, self._picture = self._picture, None
        self._silent = self._why_silent(picture, now_ns)
        if self._silent or picture.pose is None:
            self.service.complain_once("withheld_lists", f"nothing is sent: {self._silent}")
            return
        self._due_ns = now_ns + self._period_ns
        self._send(Moment(picture, picture.pose, now_ns))

    def _why_silent(self, picture: ObstacleList, now_ns: int) -> str:
        if not picture.valid:
            return "the list is not valid: " + "; ".join(picture.reasons)
        age_ns = now_ns - (picture.made_ns or picture.t_ns)
        if age_ns > STALE_NS:
            return f"the list is {age_ns / clock.NS:.1f} s old"
        if picture.pose is None or not is_finite(picture.pose):
            return "the vehicle's pose is not known"
        return ""

    def _send(self, moment: Moment) -> None:
        encoded = self._encoder.encode(moment)
        counters = self.service.counters
        sent = self._sender.send(encoded.datagrams)
        counters["sent_datagrams"] += sent
        counters["sent_lists"] += sent == len(encoded.datagrams)
        counters["left_out_obstacles"] += encoded.left_out

    def problems(self) -> list[str]:
        """Say why nothing is sent, and that nobody takes what is."""
        now_ns = clock.monotonic_ns()
        silent_s = (now_ns - self._heard_ns) / clock.NS
        no_list = f"no obstacle list for {silent_s:.1f} s" if now_ns - self._heard_ns > STALE_NS else ""
        silent = no_list or self._silent
        return [said for said in (f"nothing is sent: {silent}" if silent else "", self._sender.problem(now_ns)) if said]

    def stop(self) -> None:
        """Give the socket back."""
        self._sender.close()


class JsonWorker(BridgeWorker):
    """JSON over UDP."""

    name = "json"

    def encoder(self) -> Encoder:
        """Return what turns lists into datagrams."""
        return JsonEncoder(self.table(JsonSettings))


class TtmWorker(BridgeWorker):
    """NMEA TTM over UDP."""

    name = "ttm"

    def encoder(self) -> Encoder:
        """Return what turns lists into datagrams."""
        return TtmEncoder(self.table(TtmSettings))


class MoosWorker(BridgeWorker):
    """GIVEN_OBSTACLE to MOOS's pShare."""

    name = "moos"

    def encoder(self) -> Encoder:
        """Return what turns lists into datagrams."""
        return MoosEncoder(self.table(MoosSettings))


class MavlinkWorker(BridgeWorker):
    """OBSTACLE_DISTANCE, or OBSTACLE_DISTANCE_3D, of a list and its clearance."""

    name = "mavlink"

    def __init__(self, service: Service, settings: BridgeConfig) -> None:
        self._mavlink: MavlinkEncoder
        self._newest: dict[str, ObstacleList | Clearance] = {}
        super().__init__(service, settings)

    def encoder(self) -> Encoder:
        """Return what turns lists into datagrams."""
        try:
            from ods.bridge.mavlink import MavlinkEncoder
        except ImportError as error:
            raise StartError(f"bridge.mavlink: needs pip install 'ods[mavlink]': {error}") from error
        self._mavlink = MavlinkEncoder(self.table(MavlinkSettings))
        return self._mavlink

    def handle(self, topic: str, message: ObstacleList | Clearance) -> None:
        """Keep the newest list of which the clearance has come, too."""
        self._newest[topic] = message
        picture, clearance = self._newest.get("obstacles"), self._newest.get("clearance")
        if isinstance(picture, ObstacleList) and isinstance(clearance, Clearance) and picture.seq == clearance.seq:
            self._mavlink.take(clearance)
            super().handle("obstacles", picture)
