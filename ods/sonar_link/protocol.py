"""The seam between the sonar process and a sonar's own telegrams. Sans-IO: bytes and time in, pings and bytes out.

Another sonar is a subclass of `SonarProtocol` in a folder of its own, a row in `ods/sonar_link/registry.py`, a field of
its own settings in `SonarSettings`, and a page in docs/. Worker (service.py), line (link.py) and doctor know this class
only. They own sockets, devices and the clock; a protocol opens nothing, never waits and never reads a clock.

What the line calls, and when:

    connected      a connection was made, or the device opened; also after each loss
    feed           bytes have come
    check          every 50 ms or more often, connected or not
    requests       as often, while connected: what it returns is sent at once
    received          a datagram came to `side_port`, connected or not
    end_stream     the connection was lost; another one may follow

Of a sonar with a `command_port`, connected or not with the stream:

    commands_open  a connection to it was made; from now on `requests` is what is sent there, and not with the stream
    answered       bytes have come from it
    commands_lost  that connection was lost, or could not be made; another one may follow
"""

from abc import ABC, abstractmethod
from collections import Counter

from ods.messages import Ping
from ods.runtime.port.datagram_port import DatagramSource
from ods.sonar_link.setting_requests import SettingRequests


class SonarProtocol(ABC):
    """One sonar, or all sonars on one line, by their telegrams.

    All times are CLOCK_MONOTONIC, ns. No method raises for anything that came from outside: what cannot be used is
    dropped and counted in `counters`, in a name that has a row in the counter table. Work and memory are bounded
    whatever comes.
    """

    def __init__(self, setting_requests: SettingRequests, counters: "Counter[str]") -> None:
        self.setting_requests = setting_requests
        """What this sonar is to be set to: from the configuration, and from planners as far as it can be asked."""
        self.counters = counters
        """Those of the whole process. `pings`: pings returned; each kind of loss has a name of its own."""

    @property
    def side_port(self) -> int | None:
        """UDP port on which the sonar announces itself, by broadcast too; None: it does not. The line listens there."""
        return None

    @property
    def command_port(self) -> int | None:
        """TCP port, at the sonar's address, where it takes `requests`; None: on the connection of the stream itself."""
        return None

    @property
    def datagrams(self) -> DatagramSource | None:
        """Whose datagrams are wanted, where `sonar.port` is a UDP port of this machine or a multicast group.

        `feed` is given one at a time, whole. None: a `sonar.port` of UDP is the address of the sonar; requests go
        there, and what comes from there is a byte stream.
        """
        return None

    @property
    def wake(self) -> bytes:
        """What is sent behind a break when a serial line has been opened, to a sonar that finds the line's rate by it.

        b"": neither.
        """
        return b""

    @property
    def missing_bytes(self) -> int:
        """How many bytes at least must come before the telegram under way is whole; 0 when not known.

        Time for which the process may sleep on a serial line to gather bytes: fewer and larger reads.
        """
        return 0

    @abstractmethod
    def connected(self, now_ns: int) -> None:
        """Begin a new connection: the next `requests` returns all requests again."""

    @abstractmethod
    def feed(self, data: bytes, now_ns: int) -> list[Ping]:
        """Take the next bytes of the stream, read at `now_ns`, in any chunking; return the pings that they complete.

        A ping has `seq` (counted from 0 by the protocol), `t_ns` of its transmission, and `t_rx_ns`. Its `utc_ns` is of
        no account: the worker sets it, as all messages of this machine share one UTC.
        """

    @abstractmethod
    def check(self, now_ns: int) -> list[Ping]:
        """Give up telegrams that do not end; return the pings found behind their beginnings."""

    @abstractmethod
    def end_stream(self, now_ns: int) -> list[Ping]:
        """Forget the telegram under way; return the pings found in what is left. Another stream may follow."""

    def requests(self, now_ns: int) -> list[bytes]:
        """Return what is to be sent now, each item whole: fire messages, settings, keep-alive. None is sent twice.

        One that does not go out as a whole is lost and counted by the line (`control_unsent`).
        """
        return []

    def received(self, datagram: bytes, sender: str, now_ns: int) -> None:  # noqa: B027
        """Take what came to `side_port`, at most 64 kB, from the IP address `sender`: anybody may have sent it."""

    def commands_open(self, now_ns: int) -> None:  # noqa: B027
        """Begin a conversation on `command_port`."""

    def answered(self, data: bytes, now_ns: int) -> None:  # noqa: B027
        """Take what came on `command_port`, in any chunking."""

    def commands_lost(self, why: str, now_ns: int) -> None:  # noqa: B027
        """Forget what was under way on `command_port`. That it is away is this protocol's to say, in `problems`: while
        pings come, a list need not suffer from it.
        """

    def problems(self, now_ns: int) -> list[str]:
        """Return the sonar's problems, a text each. Silence is reported elsewhere."""
        return self.setting_requests.problems()

    @abstractmethod
    def traffic(self, seconds: float) -> str:
        """Return the complete telegrams of these seconds, since this object was made, as text: `records 7000 at 9.9
        Hz`.

        '' when none came. For `ods doctor --listen`.
        """

    @abstractmethod
    def diagnosis(self, seconds: float) -> str:
        """Return why no ping came within these seconds, and what to do about it. For `ods doctor --listen`."""
