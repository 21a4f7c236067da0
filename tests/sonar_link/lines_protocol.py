"""The smallest sonar behind the seam: lines of text. Made up; no such sonar exists.

It sends `PING number range_m amplitude ...` for one beam and `RANGE metres` for what it is set to, and takes
`HELLO` at the start of a connection and `RANGE metres`. It announces itself by UDP: `HERE name`.
"""

from collections import Counter

import numpy as np

from ods.messages import Ping
from ods.sonar_link.ping_builder import Geometry, Stamp, build_ping, make_beam_table
from ods.sonar_link.protocol import SonarProtocol
from ods.sonar_link.setting_requests import Controls, configured_requests
from ods.sonar_link.settings import SonarSettings

LONGEST_LINE = 10_000


class LinesProtocol(SonarProtocol):
    """One sonar of lines."""

    udp_port: int | None = None

    def __init__(self, settings: SonarSettings, counters: "Counter[str]") -> None:
        super().__init__(configured_requests(settings, counters), counters)
        self._held = b""
        self._begun_ns = 0
        self._hello = False
        self._name = ""

    @property
    def side_port(self) -> int | None:
        return self.udp_port

    def connected(self, now_ns: int) -> None:
        self._hello = True
        self.setting_requests.resend()

    def feed(self, data: bytes, now_ns: int) -> list[Ping]:
        self._begun_ns = self._begun_ns if self._held else now_ns
        *lines, self._held = (self._held + data).split(b"\n")
        self._lose(len(self._held) > LONGEST_LINE)
        return [ping for line in lines if (ping := self._take(line.split(), now_ns)) is not None]

    def check(self, now_ns: int) -> list[Ping]:
        self._lose(bool(self._held) and now_ns - self._begun_ns > 1_000_000_000)
        return []

    def end_stream(self, now_ns: int) -> list[Ping]:
        self._lose(bool(self._held))
        return []

    def requests(self, now_ns: int) -> list[bytes]:
        hello, self._hello = [b"HELLO\n"] if self._hello else [], False
        return hello + [b"RANGE %g\n" % order.value for order in self.setting_requests.due(now_ns)]

    def received(self, datagram: bytes, sender: str, now_ns: int) -> None:
        if datagram.startswith(b"HERE "):
            self._name = f"{datagram[5:].decode(errors='replace')} at {sender}"

    def problems(self, now_ns: int) -> list[str]:
        silent = [] if self._name else ["the sonar has not announced itself"]
        return silent + self.setting_requests.problems()

    def traffic(self, seconds: float) -> str:
        pings = self.counters["pings"]
        return f"{pings} lines of {self._name}" if pings else ""

    def diagnosis(self, seconds: float) -> str:
        return f"no line within {seconds:g} s: is it switched on?"

    def _take(self, words: list[bytes], now_ns: int) -> Ping | None:
        try:
            if words[0] == b"RANGE":
                self.setting_requests.receive(Controls(range_m=float(words[1])), now_ns)
                return None
            if words[0] != b"PING":
                raise ValueError("no such line")
            ping = self._ping(int(words[1]), float(words[2]), words[3:], now_ns)
        except (ValueError, IndexError):
            self.counters["bad_ping"] += 1
            return None
        self.counters["pings"] += 1
        return ping

    def _ping(self, number: int, range_m: float, words: list[bytes], now_ns: int) -> Ping:
        frame = np.array([[int(word) for word in words]], np.uint8)
        dr_m = range_m / frame.size
        geometry = Geometry(make_beam_table([0.0], [0.0]), 0.5 * dr_m, dr_m, 1500.0)
        return build_ping(frame, geometry, Stamp(self.counters["pings"], number, now_ns, now_ns))

    def _lose(self, lost: bool) -> None:
        if lost:
            self.counters["garbage_bytes"] += len(self._held)
            self._held = b""
