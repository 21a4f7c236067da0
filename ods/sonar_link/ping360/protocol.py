"""The Ping360 behind the seam: messages to pings, the request for a sector out. Sans-IO."""

from collections import Counter

import msgspec
import numpy as np

from ods.base.clock import NS
from ods.messages import Ping
from ods.runtime.port.address import transport_of
from ods.sonar_link.ping360 import messages, silence
from ods.sonar_link.ping360.control import SweepControl
from ods.sonar_link.ping360.framer import Framer
from ods.sonar_link.ping360.messages import TICK_S, Beam, Header, Information, Kind
from ods.sonar_link.ping360.sector import Piece, Sector, TimedBeam
from ods.sonar_link.ping360.silence import Evidence
from ods.sonar_link.ping_builder import Geometry, Stamp, build_ping, make_beam_table
from ods.sonar_link.protocol import SonarProtocol
from ods.sonar_link.setting_requests import Controls, SettingRequests
from ods.sonar_link.settings import SonarSettings
from ods.sonar_link.sync_framer import Packet

BEAM_WIDTH_RAD = 0.035
"""Two degrees, of the maker's data sheet."""
GRACE_NS = 5 * NS
"""Time for which a sonar that is asked to sweep may stay silent: its head may have to turn first."""
WAIT_NS = NS
"""Time without a beam after which the waiting ones are passed on."""
NAMES = {
    Kind.DEVICE_DATA: "single beams", Kind.AUTO_DEVICE_DATA: "beams", Kind.NACK: "refusals",
    Kind.DEVICE_INFORMATION: "device information",
}  # fmt: skip


class Ping360Protocol(SonarProtocol):
    """One Ping360, of whatever firmware.

    Counters: pings, beams; bad_ping (numbers that do not fit each other), other_records; those of Framer and
    SweepControl.
    """

    def __init__(self, settings: SonarSettings, counters: "Counter[str]") -> None:
        super().__init__(SettingRequests({}, settable=frozenset(), counters=counters), counters)
        own = settings.ping360
        self._port = settings.port
        self._sound_speed = own.sound_speed
        self._latency_ns = round(settings.latency_ms * 1e6)
        self._timeout_ns = round(settings.record_timeout_s * NS)
        self._framer = Framer(counters)
        self._sector = Sector(own.ping_s)
        self._control = SweepControl(
            own.transmission,
            own.sweep,
            counters,
            repeat_s=settings.control_repeat_s,
            attempts=settings.control_attempts,
        )
        self._kinds: Counter[int] = Counter()
        self._said: Information | None = None
        self._connected = False
        self._newest_ns: int | None = None
        """Of the newest beam; before the first, of the beginning."""
        self._turn_s = 0.0
        """Of the newest sweep."""
        self._seq = 0

    @property
    def wake(self) -> bytes:
        """Behind a break, by which it finds the line's rate."""
        return b"U"

    @property
    def missing_bytes(self) -> int:
        """How many bytes the message under way lacks."""
        return self._framer.missing_bytes

    def connected(self, now_ns: int) -> None:
        """Ask for the sector."""
        self._connected = True
        self._control.begin(now_ns)

    def requests(self, now_ns: int) -> list[bytes]:
        """Return the request for the sector where beams do not come, or others do."""
        return self._control.requests(now_ns)

    def feed(self, data: bytes, now_ns: int) -> list[Ping]:
        """Take the next bytes of the stream; return the pings that they complete."""
        return self._take(self._framer.feed(data, now_ns))

    def check(self, now_ns: int) -> list[Ping]:
        """Give up messages that do not end, and give away beams that no other follows."""
        self._newest_ns = now_ns if self._newest_ns is None else self._newest_ns
        pings = self._take(self._framer.give_up_late(now_ns, self._timeout_ns))
        waits_ns = self._sector.waits_since_ns
        if waits_ns is not None and now_ns - waits_ns > WAIT_NS:
            pings += self._pings(self._sector.end())
        return pings

    def end_stream(self, _now_ns: int) -> list[Ping]:
        """Forget the message under way; return the pings found in what is left."""
        self._connected = False
        return self._take(self._framer.flush()) + self._pings(self._sector.end())

    def problems(self, now_ns: int) -> list[str]:
        """Return why no beam comes, or that others than wanted do."""
        if self._newest_ns is not None and now_ns - self._newest_ns > GRACE_NS:
            return [silence.why(self._evidence())]
        return [self._control.problem] if self._control.problem else []

    def traffic(self, seconds: float) -> str:
        """Return which messages came, and how long a sweep takes."""
        came = [
            f"{NAMES.get(Kind(kind), 'other messages')} at {count / seconds:.1f} Hz"
            for kind, count in sorted(self._kinds.items())
        ]
        return ", ".join(came + ([f"a sweep in {self._turn_s:.1f} s"] if self._turn_s else []))

    def diagnosis(self, _seconds: float) -> str:
        """Return why no ping came."""
        return silence.why(self._evidence())

    def _evidence(self) -> Evidence:
        return Evidence(
            connected=self._connected,
            transport=transport_of(self._port),
            port=self._port,
            kinds=self._kinds,
            counters=self.counters,
            refusal=self._control.refusal,
            said=self._said,
        )

    def _take(self, found: list[Packet[Header]]) -> list[Ping]:
        pings: list[Ping] = []
        for packet in found:
            kind = packet.header.kind
            self._kinds[kind] += 1
            if kind in (Kind.DEVICE_DATA, Kind.AUTO_DEVICE_DATA):
                pings += self._beam(packet)
            elif kind == Kind.NACK:
                self._control.hear_refusal(messages.decode_id(packet.data), messages.decode_text(packet.data))
            elif kind == Kind.DEVICE_INFORMATION:
                self._said = messages.decode_information(packet.data)
            else:
                self.counters["other_records"] += 1
        return pings

    def _beam(self, packet: Packet[Header]) -> list[Ping]:
        try:
            beam = messages.decode_beam(packet.data)
        except ValueError:
            self.counters["bad_ping"] += 1
            return []
        self.counters["beams"] += 1
        self._newest_ns = packet.last_ns
        self._control.receive(beam, packet.last_ns)
        listening_ns = round(len(beam.samples) * beam.period * TICK_S * NS)
        pieces = self._sector.take(TimedBeam(beam, packet.first_ns - listening_ns - self._latency_ns))
        return self._pings(pieces, packet.last_ns)

    def _pings(self, pieces: list[Piece], last_ns: int | None = None) -> list[Ping]:
        pings = []
        for piece in pieces:
            try:
                pings.append(self._ping(piece, last_ns))
            except ValueError:
                self.counters["bad_ping"] += 1
                continue
            self._seq += 1
            self.counters["pings"] += 1
        return pings

    def _ping(self, piece: Piece, last_ns: int | None) -> Ping:
        """Raises ValueError for what can be no ping.

        Sample i lies (i + 1) sample spacings away, as a public driver has it.
        """
        beam, newest_ns = piece.newest.beam, piece.newest.t_ns
        dr_m = 0.5 * self._sound_speed * beam.period * TICK_S
        width_rad = np.full(len(piece.t_ns), BEAM_WIDTH_RAD)
        table = make_beam_table(piece.bearing_rad, np.zeros(len(piece.t_ns)), width_rad)
        geometry = Geometry(table, dr_m, dr_m, self._sound_speed, 1e3 * beam.frequency_khz)
        listened_ns = round(len(beam.samples) * beam.period * TICK_S * NS) + self._latency_ns
        read_ns = newest_ns + listened_ns if last_ns is None else last_ns
        ping = build_ping(piece.samples, geometry, Stamp(self._seq, self._seq, newest_ns, read_ns))
        self.setting_requests.receive(Controls(range_m=dr_m * ping.samples), read_ns)
        self._turn_s = piece.sweep.turn_s
        return msgspec.structs.replace(ping, beam_t_ns=piece.t_ns, sweep=piece.sweep, setting=setting_of(beam))


def setting_of(beam: Beam) -> str:
    """Return `Ping.setting`: what makes the levels of one beam unlike those of another."""
    return f"gain {beam.gain}, pulse {beam.pulse_us} us, {beam.frequency_khz} kHz"
