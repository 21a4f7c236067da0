"""The Norbit behind the seam: packets to pings, commands out at a port of their own, and their answers. Sans-IO."""

from collections import Counter

import msgspec

from ods.base.clock import NS
from ods.messages import Ping
from ods.runtime.port.address import tcp_address
from ods.sonar_link.device_clock import DeviceClock
from ods.sonar_link.norbit import image, packets, silence
from ods.sonar_link.norbit.control import CommandControl
from ods.sonar_link.norbit.framer import Framer
from ods.sonar_link.norbit.packets import FORWARD, SAMPLE_TYPES, ImageHead, PacketKind
from ods.sonar_link.norbit.silence import Evidence
from ods.sonar_link.ping_builder import Stamp, build_ping, listening_ns
from ods.sonar_link.ping_numbers import PingNumbers
from ods.sonar_link.protocol import SonarProtocol
from ods.sonar_link.setting_requests import Controls, SettingRequests
from ods.sonar_link.settings import SonarSettings
from ods.sonar_link.sync_framer import Packet

MAX_TIME_S = 1e10
"""A later time is invalid."""
GRACE_NS = 5 * NS
"""Time for which a sonar that is asked to ping may stay silent: its commands take a while."""
MODE_NAMES = {
    0: "forward", 1: "bathymetry", 2: "bathymetry by amplitude", 4: "pass-through", 5: "edge enhance",
    6: "super resolution", 7: "multi-detect",
}  # fmt: skip
KIND_NAMES = {
    PacketKind.BATHYMETRY: "bathymetry", PacketKind.IMAGE: "images", PacketKind.SNIPPETS: "snippets",
    PacketKind.SIDE_SCAN: "side scan",
}  # fmt: skip


class NorbitProtocol(SonarProtocol):
    """One WBMS, of whatever part number.

    Counters: pings, lost_pings, duplicate_pings, ping_number_restarts; bad_ping (numbers that do not fit each other),
    unsupported_layout (samples of unknown type), no_device_time, other_records, unchecked_records; those of Framer,
    CommandControl and DeviceClock.
    """

    def __init__(self, settings: SonarSettings, counters: "Counter[str]") -> None:
        super().__init__(SettingRequests({}, settable=frozenset(), counters=counters), counters)
        address = tcp_address(settings.port)
        assert address is not None  # `SonarSettings` has seen to it
        self._address = address
        self._command_port = settings.norbit.command_port or None
        self._latency_ns = round(settings.latency_ms * 1e6)
        self._timeout_ns = round(settings.record_timeout_s * NS)
        self._framer = Framer(settings.max_record_bytes, counters)
        self._control = CommandControl(
            settings.norbit.commands(),
            counters,
            repeat_s=settings.control_repeat_s,
            attempts=settings.control_attempts,
        )
        self._clock = DeviceClock(counters)
        self._numbers = PingNumbers(counters)
        self._seq = 0
        self._kinds: Counter[int] = Counter()
        self._mode = FORWARD
        self._connected = self._commanded = False
        self._no_commands = ""
        self._newest_ns: int | None = None
        """Of the newest ping; before the first, of the beginning."""

    @property
    def command_port(self) -> int | None:
        """The port of the commands."""
        return self._command_port

    @property
    def missing_bytes(self) -> int:
        """How many bytes the packet under way lacks."""
        return self._framer.missing_bytes

    def connected(self, now_ns: int) -> None:
        """Send the sonar all settings again: it may have been switched off and on."""
        self._connected = True
        self._control.begin(now_ns)

    def commands_open(self, now_ns: int) -> None:
        """Send the sonar all settings."""
        self._commanded = True
        self._control.connected(now_ns)

    def commands_lost(self, why: str, _now_ns: int) -> None:
        """Say nothing until the command port is there again."""
        self._commanded = False
        self._no_commands = why
        self._control.lost()

    def answered(self, data: bytes, now_ns: int) -> None:
        """Take answers."""
        self._control.receive(data, now_ns)

    def requests(self, now_ns: int) -> list[bytes]:
        """Return the command that is due; none without a command port."""
        return self._control.requests(now_ns)

    def feed(self, data: bytes, now_ns: int) -> list[Ping]:
        """Take the next bytes of the stream; return the pings that they complete."""
        return self._take(self._framer.feed(data, now_ns))

    def check(self, now_ns: int) -> list[Ping]:
        """Give up packets that do not end; return the pings found behind their beginnings."""
        self._newest_ns = now_ns if self._newest_ns is None else self._newest_ns
        return self._take(self._framer.give_up_late(now_ns, self._timeout_ns))

    def end_stream(self, _now_ns: int) -> list[Ping]:
        """Forget the packet under way; return the pings found in what is left."""
        self._connected = False
        return self._take(self._framer.flush())

    def problems(self, now_ns: int) -> list[str]:
        """Return why no image comes, or that the images are of another mode.

        Answers that differ from the wanted settings are counted and logged: each packet describes its own image.
        """
        if self._newest_ns is not None and now_ns - self._newest_ns > GRACE_NS:
            return [silence.why(self._evidence())]
        if self._mode == FORWARD:
            return []
        name = MODE_NAMES.get(self._mode, "unknown")
        return [
            f"the sonar works in mode {self._mode} ({name}), not {FORWARD} (forward): does another program control it?"
        ]

    def traffic(self, seconds: float) -> str:
        """Return which packets came."""
        return ", ".join(
            f"{KIND_NAMES[PacketKind(kind)]} at {count / seconds:.1f} Hz" for kind, count in sorted(self._kinds.items())
        )

    def diagnosis(self, _seconds: float) -> str:
        """Return why no ping came."""
        return silence.why(self._evidence())

    def _evidence(self) -> Evidence:
        return Evidence(
            connected=self._connected,
            commanded=self._commanded,
            no_commands=self._no_commands,
            commands=self._command_port is not None,
            answered=self._control.answered,
            objections=self._control.problems(),
            host=self._address.host,
            port=self._address.port,
            kinds=self._kinds,
            counters=self.counters,
        )

    def _take(self, found: list[Packet[packets.Header]]) -> list[Ping]:
        pings = []
        for packet in found:
            self._kinds[packet.header.kind] += 1
            if packet.header.kind != PacketKind.IMAGE:
                self.counters["other_records"] += 1
                continue
            if not packet.header.checksum:
                self.counters["unchecked_records"] += 1
            ping = self._ping(packet, packets.decode_image_head(packet.data))
            pings += [] if ping is None else [ping]
        return pings

    def _ping(self, packet: Packet[packets.Header], head: ImageHead) -> Ping | None:
        if head.ping_number == self._numbers.newest:
            self.counters["duplicate_pings"] += 1
            return None
        if head.sample_type not in SAMPLE_TYPES:
            self.counters["unsupported_layout"] += 1
            return None
        try:
            frame, geometry = image.amplitudes_of(head, packet.data), image.geometry_of(head, packet.data)
            ping = build_ping(frame, geometry, Stamp(self._seq, head.ping_number, 0, packet.last_ns))
        except ValueError:
            self.counters["bad_ping"] += 1
            return None
        self._seq += 1
        self._numbers.follow(head.ping_number)
        self._mode, self._newest_ns = head.mode, packet.last_ns
        self.setting_requests.receive(Controls(range_m=ping.range0_m + (ping.samples - 1) * ping.dr_m), packet.last_ns)
        self.counters["pings"] += 1
        sent_ns = self._sent_ns(head.time_s, packet.first_ns, listening_ns(ping))
        return msgspec.structs.replace(ping, t_ns=sent_ns, setting=setting_of(head))

    def _sent_ns(self, time_s: float, first_ns: int, listening: int) -> int:
        """Return the time of transmission: the packet left the sonar at the earliest this time after it."""
        delay_ns = listening + self._latency_ns
        if not 0.0 < time_s < MAX_TIME_S:  # false for NaN too
            self.counters["no_device_time"] += 1
            return first_ns - delay_ns
        return self._clock.local_ns(round(time_s * NS) + delay_ns, first_ns) - delay_ns


def setting_of(head: ImageHead) -> str:
    """Return `Ping.setting`: what makes the levels of one image unlike those of another."""
    return (
        f"mode {head.mode}, {head.frequency:g} kHz, amplitude {head.amplitude}, gain {head.gain:g}, "
        f"ramp {head.gain_from_db:g} to {head.gain_to_db:g} dB"
    )
