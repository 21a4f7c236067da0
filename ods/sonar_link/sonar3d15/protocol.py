"""Speaks with a Sonar 3D-15: takes its packets, one in a datagram, and says why none comes. Sans-IO."""

from collections import Counter

import msgspec

from ods.base.clock import NS
from ods.messages import Ping
from ods.runtime.port.address import udp_address
from ods.runtime.port.datagram_port import DatagramSource
from ods.sonar_link.device_clock import DeviceClock
from ods.sonar_link.ping_builder import Stamp, farthest_m, listening_ns
from ods.sonar_link.ping_numbers import PingNumbers
from ods.sonar_link.protocol import SonarProtocol
from ods.sonar_link.setting_requests import Controls, SettingRequests
from ods.sonar_link.settings import SonarSettings
from ods.sonar_link.sonar3d15 import packets, silence
from ods.sonar_link.sonar3d15.image import LATEST_NS, ping_of
from ods.sonar_link.sonar3d15.packets import BITMAP, IMU, RANGE_IMAGE, RangeImage
from ods.sonar_link.sonar3d15.silence import Evidence

GRACE_NS = 5 * NS
"""Silence that is reported, ns."""
NAMES = {RANGE_IMAGE: "range images", BITMAP: "pictures of signal strength", IMU: "inertial measurements"}
OTHERS = "other messages"


class Sonar3d15Protocol(SonarProtocol):
    """One Sonar 3D-15, of whatever model and version.

    Counters: pings, lost_pings, duplicate_pings, ping_number_restarts; records, other_records; of what is no packet
    unknown_message, short_record, overlong_record, truncated_record, bad_checksum, garbage_bytes; bad_ping (a damaged
    message, or numbers that do not fit each other), no_device_time; those of DeviceClock.
    """

    def __init__(self, settings: SonarSettings, counters: "Counter[str]") -> None:
        super().__init__(SettingRequests({}, settable=frozenset(), counters=counters), counters)
        address = udp_address(settings.port)
        assert address is not None  # `SonarSettings` has seen to it
        self._address = address
        self._source = DatagramSource(settings.sonar3d15.interface, settings.sonar3d15.sender)
        self._latency_ns = round(settings.latency_ms * 1e6)
        self._max_bytes = min(settings.max_record_bytes, packets.MAX_PACKET_BYTES)
        self._clock = DeviceClock(counters)
        self._numbers = PingNumbers(counters)
        self._seq = 0
        self._kinds: Counter[str] = Counter()
        self._opened = False
        self._newest_ns: int | None = None
        """Of the newest ping; before the first, of the beginning."""

    @property
    def datagrams(self) -> DatagramSource:
        """The sonar's."""
        return self._source

    def connected(self, _now_ns: int) -> None:
        """The port is open."""
        self._opened = True

    def feed(self, data: bytes, now_ns: int) -> list[Ping]:
        """Take a datagram; return its ping."""
        if fault := self._fault_of(data):
            self.counters[fault] += 1
            self.counters["garbage_bytes"] += len(data)
            return []
        self.counters["records"] += 1
        try:
            packet = packets.unpack(data)
            self._kinds[NAMES.get(packet.kind, OTHERS)] += 1
            if packet.kind != RANGE_IMAGE:
                self.counters["other_records"] += 1
                return []
            ping = self._ping(packets.decode_range_image(packet.message), now_ns)
        except ValueError:
            self.counters["bad_ping"] += 1
            return []
        return [] if ping is None else [ping]

    def check(self, now_ns: int) -> list[Ping]:
        """Nothing is under way between two datagrams."""
        self._newest_ns = now_ns if self._newest_ns is None else self._newest_ns
        return []

    def end_stream(self, _now_ns: int) -> list[Ping]:
        """The port is closed."""
        self._opened = False
        return []

    def problems(self, now_ns: int) -> list[str]:
        """Return why no image comes."""
        silent = self._newest_ns is not None and now_ns - self._newest_ns > GRACE_NS
        return [silence.why(self._evidence())] if silent and self._opened else []

    def traffic(self, seconds: float) -> str:
        """Return which messages came."""
        return ", ".join(f"{name} at {count / seconds:.1f} Hz" for name, count in sorted(self._kinds.items()))

    def diagnosis(self, _seconds: float) -> str:
        """Return why no ping came."""
        return silence.why(self._evidence())

    def _evidence(self) -> Evidence:
        return Evidence(self._address, self._source, self._kinds, self.counters, NAMES[RANGE_IMAGE])

    def _fault_of(self, data: bytes) -> str:
        """Return why a datagram is no packet, '' when it is one."""
        fault = packets.fault_of(data, 0, self._max_bytes)
        if fault is None:
            return "truncated_record"
        if fault:
            return fault
        if packets.size_of(data) != len(data):
            return "truncated_record"
        return "" if packets.is_sound(data) else "bad_checksum"

    def _ping(self, image: RangeImage, now_ns: int) -> Ping | None:
        if image.number == self._numbers.newest:
            self.counters["duplicate_pings"] += 1
            return None
        ping = ping_of(image, Stamp(self._seq, image.number, 0, now_ns))
        self._seq += 1
        self._numbers.follow(image.number)
        self._newest_ns = now_ns
        self.setting_requests.receive(Controls(range_m=farthest_m(ping)), now_ns)
        self.counters["pings"] += 1
        return msgspec.structs.replace(ping, t_ns=self._sent_ns(image.time_ns, now_ns, listening_ns(ping)))

    def _sent_ns(self, time_ns: int, now_ns: int, listening: int) -> int:
        """Return the time of transmission: the packet left the sonar at the earliest this time after it."""
        delay_ns = listening + self._latency_ns
        if not 0 < time_ns < LATEST_NS:
            self.counters["no_device_time"] += 1
            return now_ns - delay_ns
        return self._clock.local_ns(time_ns + delay_ns, now_ns) - delay_ns
