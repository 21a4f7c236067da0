"""The UDP bridges as processes: obstacle lists to other planners. Lists that are not valid are not sent."""

from abc import abstractmethod
from typing import TYPE_CHECKING

from ods.bridge.encoder import Encoder
from ods.bridge.extrapolated_list import ExtrapolatedList
from ods.bridge.json_udp import JsonEncoder
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
from ods.bridge.worker import ListWorker
from ods.messages import Clearance, ObstacleList
from ods.runtime.service import Service, StartError

if TYPE_CHECKING:
    from ods.bridge.mavlink import MavlinkEncoder


class BridgeWorker(ListWorker):
    """Sends datagrams to one receiver.

    Counters: sent_lists, sent_datagrams, left_out_obstacles, and those of `ListWorker` and `UdpSender`.
    """

    needs = ": set `to`, the receiver's address"

    def __init__(self, service: Service, settings: BridgeConfig) -> None:
        super().__init__(service, settings)
        self._sender = UdpSender(destination_of(self.table(UdpSettings).to), service.log_once)
        self._encoder = self.encoder()

    @abstractmethod
    def encoder(self) -> Encoder:
        """Return what turns lists into datagrams."""

    def send(self, extrapolated: ExtrapolatedList) -> None:
        """Send a list's datagrams."""
        encoded = self._encoder.encode(extrapolated)
        counters = self.service.counters
        sent = self._sender.send(encoded.datagrams)
        counters["sent_datagrams"] += sent
        counters["sent_lists"] += sent == len(encoded.datagrams)
        counters["left_out_obstacles"] += encoded.left_out

    def peer_problem(self, now_ns: int) -> str:
        """Return a text that the receiver takes no data, or ""."""
        return self._sender.problem(now_ns)

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
        obstacle_list, clearance = self._newest.get("obstacles"), self._newest.get("clearance")
        if (
            isinstance(obstacle_list, ObstacleList)
            and isinstance(clearance, Clearance)
            and obstacle_list.seq == clearance.seq
        ):
            self._mavlink.take(clearance)
            super().handle("obstacles", obstacle_list)
