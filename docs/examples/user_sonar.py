"""A sonar of your own, the Sketch. A telegram: `PING`, beams and samples (uint16), then beams x samples uint8."""

import struct
from collections import Counter

import msgspec
import numpy as np

from ods.base.arrays import AnyArray
from ods.base.clock import NS
from ods.messages import Ping
from ods.sonar_link.ping_builder import Geometry, Stamp, build_ping, listening_ns, make_beam_table
from ods.sonar_link.protocol import SonarProtocol
from ods.sonar_link.registry import sonar_protocol
from ods.sonar_link.setting_requests import configured_requests
from ods.sonar_link.settings import SonarSettings

_SYNC = b"PING"
_HEAD = struct.Struct("<4sHH")


@sonar_protocol("sketch", transports={"serial", "socket"}, sonars="an imaginary sonar")
class SketchProtocol(SonarProtocol):
    """One Sketch. Counters: pings, bad_ping, garbage_bytes."""

    def __init__(self, settings: SonarSettings, counters: "Counter[str]") -> None:
        super().__init__(configured_requests(settings, counters), counters)
        self._longest = settings.max_record_bytes
        self._timeout_ns = round(settings.record_timeout_s * NS)
        self._bytes = bytearray()
        self._fed_ns = 0
        self._seq = 0

    def connected(self, now_ns: int) -> None:
        """The Sketch sends by itself."""

    def feed(self, data: bytes, now_ns: int) -> list[Ping]:
        """Take the next bytes of the stream."""
        self._bytes += data
        self._fed_ns = now_ns
        return self._pings(now_ns)

    def check(self, now_ns: int) -> list[Ping]:
        """Disbelieve a telegram that does not end."""
        if not self._bytes or now_ns - self._fed_ns < self._timeout_ns:
            return []
        self._fed_ns = now_ns
        self._drop(1)
        return self._pings(now_ns)

    def end_stream(self, now_ns: int) -> list[Ping]:
        """Forget the telegram under way."""
        self._drop(len(self._bytes))
        return []

    def traffic(self, seconds: float) -> str:
        """Say how many telegrams came."""
        return f"telegrams at {self._seq / seconds:.1f} Hz" if self._seq else ""

    def diagnosis(self, seconds: float) -> str:
        """Say why no ping came."""
        return "bytes of no telegram: baud, wiring?" if self.counters["garbage_bytes"] else "it is silent: is it on?"

    def _pings(self, now_ns: int) -> list[Ping]:
        pings = []
        while (frame := self._next_frame()) is not None:
            try:
                pings.append(self._ping(frame, now_ns))
            except ValueError:
                self.counters["bad_ping"] += 1
        return pings

    def _next_frame(self) -> AnyArray | None:
        while len(self._bytes) >= _HEAD.size:
            sync, beams, samples = _HEAD.unpack_from(self._bytes)
            end = _HEAD.size + beams * samples
            if sync != _SYNC or end > self._longest:
                self._drop(1)
            elif len(self._bytes) < end:
                break
            else:
                frame = np.frombuffer(bytes(self._bytes[_HEAD.size : end]), np.uint8).reshape(beams, samples)
                del self._bytes[:end]
                return frame
        return None

    def _ping(self, frame: AnyArray, now_ns: int) -> Ping:
        """Raises ValueError for a frame that is none."""
        bearings = np.radians(np.linspace(-45.0, 45.0, len(frame)))
        table = make_beam_table(bearings, np.zeros(len(frame)))
        geometry = Geometry(table, range0_m=0.0, dr_m=0.05, sound_speed=1500.0)
        ping = build_ping(frame, geometry, Stamp(self._seq, self._seq, now_ns, now_ns))
        self._seq += 1
        self.counters["pings"] += 1
        return msgspec.structs.replace(ping, t_ns=now_ns - listening_ns(ping))

    def _drop(self, count: int) -> None:
        self.counters["garbage_bytes"] += count
        del self._bytes[:count]
