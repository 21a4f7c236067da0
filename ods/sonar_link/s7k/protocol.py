"""The live stream of a sonar that speaks the RESON 7k Data Format, on a serial line or over TCP."""

from collections import Counter
from collections.abc import Callable

import msgspec

from ods.base import clock
from ods.messages import Ping
from ods.runtime.port.address import transport_of
from ods.sonar_link.device_clock import DeviceClock
from ods.sonar_link.ping_builder import listening_ns
from ods.sonar_link.protocol import SonarProtocol
from ods.sonar_link.s7k import records, remote_control
from ods.sonar_link.s7k.assembler import MAX_SONARS, Assembler
from ods.sonar_link.s7k.control import RemoteControl
from ods.sonar_link.s7k.drf import DeviceId, S7kRecord
from ods.sonar_link.s7k.framer import RecordFramer
from ods.sonar_link.s7k.loss import RecordError
from ods.sonar_link.s7k.network_frame import Deframer, frame_record
from ods.sonar_link.setting_requests import configured_requests
from ods.sonar_link.settings import SonarSettings

TOLD_NS = 5 * clock.NS
"""Time for which another sonar is reported after its last ping, ns."""
REPLIES = {remote_control.ACKNOWLEDGED, remote_control.REFUSED}
SAMPLES = {records.BEAMFORMED_DATA, records.COMPRESSED_WATER_COLUMN}


class S7kProtocol(SonarProtocol):
    """Bytes through network frames (over tcp://), framer and assembler to pings; remote control the other way."""

    def __init__(
        self,
        settings: SonarSettings,
        counters: "Counter[str]",
        utc_of: Callable[[int], int] = clock.utc_ns,
    ) -> None:
        """`utc_of`: UTC of a monotonic instant, ns; requests bear it."""
        super().__init__(configured_requests(settings, counters), counters)
        framed = transport_of(settings.port) == "tcp"
        wanted = records.SONAR_SETTINGS, records.BEAM_GEOMETRY, settings.s7k.samples_record
        self._utc_of = utc_of
        self._latency_ns = round(settings.latency_ms * 1e6)
        self._timeout_ns = round(settings.record_timeout_s * clock.NS)
        self._deframer = Deframer(settings.max_record_bytes, counters) if framed else None
        self._framer = RecordFramer(settings.max_record_bytes, counters)
        self._assembler = Assembler(counters)
        self._control = RemoteControl(self.setting_requests, wanted if framed else ())
        self._clocks: dict[DeviceId, DeviceClock] = {}
        """Each sonar's own."""
        self._pinged_ns: dict[DeviceId, int] = {}
        """When the newest ping of each came."""
        self._sonar = records.DEVICE
        """The device that requests go to: that of the last settings received."""
        self._transmissions = 0
        self._record_types: Counter[int] = Counter()

    @property
    def missing_bytes(self) -> int:
        """How many bytes the record under way needs at least."""
        return self._framer.missing_bytes

    def connected(self, now_ns: int) -> None:
        """Subscribe, and ask for all settings again."""
        self._control.connected()

    def feed(self, data: bytes, now_ns: int) -> list[Ping]:
        """Take the next bytes of the stream."""
        return self._take(self._framer.feed(self._deframer.feed(data) if self._deframer else data, now_ns))

    def check(self, now_ns: int) -> list[Ping]:
        """Give up records that take longer than `record_timeout_s`."""
        return self._take(self._framer.give_up_late(now_ns, self._timeout_ns))

    def end_stream(self, now_ns: int) -> list[Ping]:
        """Take what is left of the stream of a line that was lost."""
        found = self._framer.feed(self._deframer.flush(), now_ns) if self._deframer else []
        return self._take(found + self._framer.flush())

    def requests(self, now_ns: int) -> list[bytes]:
        """Return the subscription and the settings that are due, framed."""
        return [self._framed(request, now_ns) for request in self._control.requests(now_ns)]

    def problems(self, now_ns: int) -> list[str]:
        """Return the requests that the sonar refused, and that another sonar uses the line, as text."""
        return self._others(now_ns) + self._control.problems()

    def _others(self, now_ns: int) -> list[str]:
        """Return a text that several sonars ping: images of all are taken for those of the one whose mounting is
        configured."""
        received = sorted(device for device, t_ns in self._pinged_ns.items() if now_ns - t_ns < TOLD_NS)
        if len(received) < 2:
            return []
        names = ", ".join(f"{device.number}:{device.enumerator}" for device in received)
        return [f"{len(received)} sonars ping on this line (devices {names}): leave one on"]

    def traffic(self, seconds: float) -> str:
        """Return how often each type of record came."""
        rates = [f"{kind} at {count / seconds:.1f} Hz" for kind, count in sorted(self._record_types.items())]
        return f"records {', '.join(rates)}" if rates else ""

    def diagnosis(self, seconds: float) -> str:
        """Return which records are missing for a ping."""
        came = self._record_types
        if not came:
            garbage = self.counters["garbage_bytes"]
            noise = f"{garbage} bytes outside records came: check baud, wiring and protocol"
            return f"no s7k record within {seconds:g} s; {noise if garbage else 'it is silent'}"
        missing = [str(kind) for kind in (records.SONAR_SETTINGS, records.BEAM_GEOMETRY) if not came[kind]]
        if not SAMPLES & came.keys():
            missing.append(f"{records.COMPRESSED_WATER_COLUMN} or {records.BEAMFORMED_DATA}")
        why = f"{' and '.join(missing)} never arrived complete" if missing else "they do not fit together"
        return (
            f"no ping can be made of {self.traffic(seconds)}: {why}; "
            "switch 7000, 7004 and 7042 on at the sonar, for every ping"
        )

    def _take(self, found: list[S7kRecord]) -> list[Ping]:
        return [ping for record in found if (ping := self._take_record(record)) is not None]

    def _take_record(self, record: S7kRecord) -> Ping | None:
        self._record_types[record.record_type] += 1
        if record.record_type in REPLIES:
            self._take_reply(record)
            return None
        content = records.decode(record)
        if isinstance(content, records.SettingsRecord):
            self._sonar = record.device
            self._control.take(content.controls, record.last_ns)
        ping = self._assembler.feed(record, content)
        device_clock = self._clock_of(record.device)  # known as long as the assembler knows the sonar
        if ping is None:
            return None
        self._pinged_ns[record.device] = record.last_ns
        return self._on_our_clock(ping, record, device_clock)

    def _take_reply(self, record: S7kRecord) -> None:
        try:
            self._control.answered(remote_control.decode_reply(record))
        except RecordError as error:
            self.counters[error.loss.value] += 1

    def _on_our_clock(self, ping: Ping, record: S7kRecord, device_clock: DeviceClock) -> Ping:
        """Return the ping with its time of transmission; its record left the sonar `delay_ns` later at the earliest."""
        delay_ns = listening_ns(ping) + self._latency_ns
        left_ns = record.first_ns
        if record.time_ns is not None:
            left_ns = device_clock.local_ns(record.time_ns + delay_ns, record.first_ns)
        return msgspec.structs.replace(ping, t_ns=left_ns - delay_ns)

    def _clock_of(self, device: DeviceId) -> DeviceClock:
        if device not in self._clocks:
            if len(self._clocks) >= MAX_SONARS:
                self._clocks.clear()
                self._pinged_ns.clear()
            self._clocks[device] = DeviceClock(self.counters)
        return self._clocks[device]

    def _framed(self, request: remote_control.ControlRequest, now_ns: int) -> bytes:
        record = remote_control.encode_request(request, self._utc_of(now_ns), self._sonar)
        if self._deframer is None:
            return record
        self._transmissions += 1
        return frame_record(record, self._transmissions)
