"""The Oculus behind the seam: messages to pings, the fire message out, the status broadcast received. Sans-IO."""

from collections import Counter

import msgspec

from ods.base.clock import NS
from ods.messages import Ping
from ods.runtime.port.address import tcp_address
from ods.sonar_link.device_clock import DeviceClock
from ods.sonar_link.oculus import image, messages
from ods.sonar_link.oculus.control import FireControl
from ods.sonar_link.oculus.framer import Framer
from ods.sonar_link.oculus.messages import MessageKind, SimpleResult
from ods.sonar_link.oculus.status import StatusBoard, model_of
from ods.sonar_link.ping_builder import Stamp, build_ping, listening_ns
from ods.sonar_link.ping_numbers import PingNumbers
from ods.sonar_link.protocol import SonarProtocol
from ods.sonar_link.setting_requests import Controls, SettingRequests
from ods.sonar_link.settings import SonarSettings
from ods.sonar_link.sync_framer import Packet

MAX_UPTIME_S = 1e9
"""A start time beyond it is no time."""
STANDBY_NS = 2 * NS
"""Time after a dummy message for which the sonar counts as in standby."""
MAX_TEMPERATURE_C = 200.0
"""What is beyond was not measured: recorded results hold such numbers."""
GRACE_NS = 5 * NS // 2
"""A silence of statuses is none before: they come about once a second."""
KIND_NAMES = {
    MessageKind.FIRE: "fire messages", MessageKind.FULL_PING: "full ping results", MessageKind.PING: "ping results",
    MessageKind.USER_CONFIG: "user configurations", MessageKind.LOG: "logs", MessageKind.DUMMY: "dummies",
}  # fmt: skip


class OculusProtocol(SonarProtocol):
    """One Oculus.

    Counters: pings, lost_pings, duplicate_pings, ping_number_restarts; bad_ping (numbers that do not fit each other),
    unsupported_layout (24-bit samples), no_device_time (first-version results), other_records; those of Framer,
    FireControl, StatusBoard and DeviceClock.
    """

    def __init__(self, settings: SonarSettings, counters: "Counter[str]") -> None:
        super().__init__(SettingRequests({}, settable=frozenset(), counters=counters), counters)
        address = tcp_address(settings.port)
        assert address is not None  # `SonarSettings` has seen to it
        self._status_port = settings.oculus.status_port
        self._latency_ns = round(settings.latency_ms * 1e6)
        self._timeout_ns = round(settings.record_timeout_s * NS)
        self._framer = Framer(settings.max_record_bytes, counters)
        self._control = FireControl(settings.oculus, counters)
        self._board = StatusBoard(address.host, counters)
        self._clock = DeviceClock(counters)
        self._numbers = PingNumbers(counters)
        self._seq = 0
        self._kinds: Counter[int] = Counter()
        self._dummy_ns: int | None = None
        self._connected = False
        self._begun_ns: int | None = None

    @property
    def side_port(self) -> int | None:
        """The port of the status broadcast."""
        return self._status_port or None

    @property
    def missing_bytes(self) -> int:
        """How many bytes the message under way lacks."""
        return self._framer.missing_bytes

    def connected(self, now_ns: int) -> None:
        """Send the fire message."""
        self._connected = True
        self._control.connected(now_ns)

    def feed(self, data: bytes, now_ns: int) -> list[Ping]:
        """Take the next bytes of the stream; return the pings that they complete."""
        return self._take(self._framer.feed(data, now_ns))

    def check(self, now_ns: int) -> list[Ping]:
        """Give up messages that do not end; return the pings found behind their beginnings."""
        self._begun_ns = now_ns if self._begun_ns is None else self._begun_ns
        return self._take(self._framer.give_up_late(now_ns, self._timeout_ns))

    def end_stream(self, now_ns: int) -> list[Ping]:
        """Forget the message under way; return the pings found in what is left."""
        self._connected = False
        self._begun_ns = now_ns
        self._control.lost()
        return self._take(self._framer.flush())

    def requests(self, now_ns: int) -> list[bytes]:
        """Return the fire message when it is due."""
        return self._control.requests(now_ns)

    def received(self, datagram: bytes, _sender: str, now_ns: int) -> None:
        """Take a status; the address in it counts, not the sender's, as a router may stand between."""
        self._board.receive(datagram, now_ns)

    def problems(self, now_ns: int) -> list[str]:
        """Return what is wrong with the sonar, its settings or the way to it."""
        said = self._board.problems(now_ns)
        if self._connected:
            if self._dummy_ns is not None and now_ns - self._dummy_ns < STANDBY_NS:
                said.append("the sonar is in standby")
            return said + self._control.problems(now_ns)
        waited = self._begun_ns is not None and now_ns - self._begun_ns > GRACE_NS
        received = self._board.own(now_ns) or self._board.other(now_ns)
        return said + ([self._board.why_unreachable(now_ns)] if self.side_port and (received or waited) else [])

    def traffic(self, seconds: float) -> str:
        """Return which messages came, and from which sonar."""
        kinds = [
            f"{KIND_NAMES[MessageKind(kind)]} at {count / seconds:.1f} Hz"
            for kind, count in sorted(self._kinds.items())
        ]
        return ", ".join(kinds) + (f" from {self._who()}" if kinds and self._who() else "")

    def diagnosis(self, _seconds: float) -> str:
        """Return why no ping came."""
        if self._kinds[MessageKind.PING]:
            return "its ping results cannot be decoded: see the counters"
        if self._kinds[MessageKind.FULL_PING]:
            return "it sends full ping results for another program: end that program, switch the sonar off and on"
        if self._kinds[MessageKind.DUMMY]:
            return "it is in standby and ignores the fire message: is another program connected to it?"
        newest_ns = self._board.newest_ns
        return self._board.why_unreachable(newest_ns) if self.side_port else "it is silent"

    def _who(self) -> str:
        status = self._board.own(self._board.newest_ns)
        if status is None:
            return ""
        warmest_c = max((t for t in status.temperatures_c if abs(t) < MAX_TEMPERATURE_C), default=None)
        warmth = "" if warmest_c is None else f", {warmest_c:.0f} deg C at its warmest"
        return f"{model_of(status)} number {status.device} at {status.address}{warmth}"

    def _take(self, found: list[Packet[messages.Header]]) -> list[Ping]:
        pings = []
        for message in found:
            self._kinds[message.header.kind] += 1
            if message.header.kind == MessageKind.PING:
                ping = self._ping(message, messages.decode_ping_result(message.data))
                pings += [] if ping is None else [ping]
            else:
                self.counters["other_records"] += 1
                if message.header.kind == MessageKind.DUMMY:
                    self._dummy_ns = message.last_ns
        return pings

    def _ping(self, message: Packet[messages.Header], result: SimpleResult) -> Ping | None:
        if result.ping_number == self._numbers.newest:
            self.counters["duplicate_pings"] += 1
            return None
        if result.sample_bytes not in image.SAMPLE_TYPES:
            self.counters["unsupported_layout"] += 1
            return None
        try:
            frame, geometry = image.amplitudes_of(result, message.data), image.geometry_of(result, message.data)
            ping = build_ping(frame, geometry, Stamp(self._seq, result.ping_number, 0, message.last_ns, 0))
        except ValueError:
            self.counters["bad_ping"] += 1
            return None
        self._seq += 1
        self._numbers.follow(result.ping_number)
        self._control.receive(result.fire, message.last_ns)
        self.setting_requests.receive(Controls(range_m=result.fire.range_m), message.last_ns)
        self.counters["pings"] += 1
        sent_ns = self._sent_ns(result.start_s, message.first_ns, listening_ns(ping))
        fire = result.fire
        setting = f"mode {fire.mode}, gain {fire.gain_percent:g} %, gamma {fire.gamma}"
        return msgspec.structs.replace(ping, t_ns=sent_ns, setting=setting)

    def _sent_ns(self, start_s: float | None, first_ns: int, listening: int) -> int:
        """Return the time of transmission: the result left the sonar at the earliest this time after it."""
        delay_ns = listening + self._latency_ns
        if start_s is None or not 0.0 < start_s < MAX_UPTIME_S:  # false for NaN too
            self.counters["no_device_time"] += 1
            return first_ns - delay_ns
        return self._clock.local_ns(round(start_s * NS) + delay_ns, first_ns) - delay_ns
