"""The CAN interface: opened, read, and opened again when it fails or falls silent."""

import contextlib
import logging
import os
import socket
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import can

from ods import clock
from ods.errors import OdsError
from ods.nav_bridge.can_frame import CanId, Frame
from ods.nav_bridge.settings import CanSettings
from ods.nav_bridge.slcan_bus import SlcanBus

log = logging.getLogger(__name__)

READ_LIMIT = 512
"""Frames read in one go, so that a flood leaves time for the rest of the loop."""
FULL_MASK = {False: 0x7FF, True: 0x1FFFFFFF}
"""All bits of a standard and of an extended identifier."""
SEND_TIMEOUT_S = 0.02
FIRST_RETRY_NS, LAST_RETRY_NS = 100_000_000, 1_000_000_000
IFF_UP = 1
FailedBus = (can.CanError, OSError)


class CanLink:
    """One CAN interface, kept open.

    Without a thread: its owner calls `read` when the descriptor given to `opened` is readable, and `tick` often.
    `closing` comes before that descriptor is closed. Counts `can_opened`, `can_lost`, `can_silent`, `can_ignored`
    (remote, error and FD frames), `can_unsent`.
    """

    def __init__(
        self,
        settings: CanSettings,
        ids: Iterable[CanId],
        counters: Counter[str],
        opened: Callable[[int | None], None],
        closing: Callable[[int | None], None],
    ) -> None:
        self._settings = settings
        self._ids = sorted(ids)
        self._counters = counters
        self._opened, self._closing = opened, closing
        self._silence_ns = round(settings.silence_s * clock.NS)
        self._bus: can.BusABC | None = None
        self._fd: int | None = None
        self._why = "not open yet"
        self._said = ""
        self._retry_ns = 0
        self._delay_ns = FIRST_RETRY_NS
        self._heard_ns = clock.monotonic_ns()
        self._opened_ns = 0

    @property
    def is_open(self) -> bool:
        """Tell whether the interface is open."""
        return self._bus is not None

    def tick(self) -> None:
        """Open the interface when it is due, give it up when it is silent. Raises OdsError for bad settings."""
        now_ns = clock.monotonic_ns()
        if self._bus is not None and now_ns - max(self._heard_ns, self._opened_ns) > self._silence_ns:
            self._counters["can_silent"] += 1
            self.close()
            self._retry_ns = now_ns
        if self._bus is None and now_ns >= self._retry_ns:
            self._open(now_ns)

    def read(self) -> Iterator[Frame]:
        """Yield the frames that have arrived."""
        try:
            for _ in range(READ_LIMIT):
                message = self._bus.recv(0) if self._bus is not None else None
                if message is None:
                    return
                self._heard(clock.arrival_ns(message.timestamp))
                if message.is_remote_frame or message.is_error_frame or message.is_fd:
                    self._counters["can_ignored"] += 1
                    continue
                yield Frame(message.arbitration_id, message.is_extended_id, bytes(message.data), self._heard_ns)
        except FailedBus as error:
            self._lost(error)

    def send(self, can_id: int, data: bytes) -> None:
        """Send a standard data frame; one that cannot go out is counted and forgotten."""
        if self._bus is None:
            return
        message = can.Message(arbitration_id=can_id, data=data, is_extended_id=False)
        try:
            self._bus.send(message, timeout=SEND_TIMEOUT_S)
        except FailedBus:
            self._counters["can_unsent"] += 1

    def problems(self) -> list[str]:
        """Say in plain words what is wrong with the interface."""
        if self._bus is None:
            return [f"{self._settings.channel}: {self._why}"]
        if self._settings.interface == "socketcan" and not _is_up(self._settings.channel):
            return [f"{self._settings.channel}: is down"]
        silent_ns = clock.monotonic_ns() - self._heard_ns
        if silent_ns > self._silence_ns:
            return [f"{self._settings.channel}: no CAN frame for {silent_ns / clock.NS:.1f} s"]
        return []

    def close(self) -> None:
        """Give the interface back."""
        bus, self._bus = self._bus, None
        if bus is None:
            return
        self._closing(self._fd)
        self._fd = None
        with contextlib.suppress(*FailedBus):
            bus.shutdown()
        port = getattr(bus, "serialPortOrig", None)  # slcan leaves it open when its last command cannot be sent
        if port is not None:
            port.close()

    def _open(self, now_ns: int) -> None:
        try:
            self._bus = self._new_bus()
        except (*FailedBus, ValueError, NotImplementedError, TypeError) as error:
            _refuse_bad_settings(self._settings, error)
            self._try_later(error)
            return
        self._counters["can_opened"] += 1
        self._opened_ns = now_ns
        with contextlib.suppress(NotImplementedError):  # `virtual` has no descriptor: its owner polls
            self._fd = self._bus.fileno()
        self._opened(self._fd)

    def _new_bus(self) -> can.BusABC:
        settings = self._settings
        options: dict[str, Any] = {}
        if settings.bitrate is not None:
            options["bitrate"] = settings.bitrate
        if settings.interface == "socketcan":  # the kernel filters at no cost; elsewhere python-can would, slowly
            options["can_filters"] = [
                {"can_id": number, "can_mask": FULL_MASK[extended], "extended": extended}
                for number, extended in self._ids
            ]
        options |= settings.options
        if settings.interface == "slcan":
            return SlcanBus(settings.channel, self._counters, **options)
        bus = can.Bus(settings.channel, settings.interface, ignore_config=True, **options)
        sock = getattr(bus, "socket", None)
        if isinstance(sock, socket.socket):
            _enlarge(sock, settings.receive_buffer_bytes)
        return bus

    def _lost(self, error: Exception) -> None:
        self._counters["can_lost"] += 1
        self.close()
        self._try_later(error)

    def _try_later(self, error: Exception) -> None:
        """Wait longer each time until a frame is heard; say the reason once."""
        self._why = plain_words(error)
        self._retry_ns = clock.monotonic_ns() + self._delay_ns
        self._delay_ns = min(2 * self._delay_ns, LAST_RETRY_NS)
        if self._why != self._said:
            self._said = self._why
            log.warning("%s: %s; trying again", self._settings.channel, self._why)

    def _heard(self, arrival_ns: int) -> None:
        self._heard_ns = arrival_ns
        self._delay_ns = FIRST_RETRY_NS
        if self._said:
            self._said = ""
            log.info("%s: frames arrive again", self._settings.channel)


def _is_up(channel: str) -> bool:
    """Tell whether a network interface is set up; a socket opens on one that is down, too."""
    try:
        flags = int((Path("/sys/class/net") / channel / "flags").read_text(), 16)
    except (OSError, ValueError):
        return True  # gone: reading tells
    return bool(flags & IFF_UP)


def plain_words(error: BaseException) -> str:
    """Return the operating system's word for what is behind `error`, else its own text, as one line."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, OSError) and cause.errno:
            return os.strerror(cause.errno).lower()
        cause = cause.__cause__
    return " ".join(str(error).split())


def _refuse_bad_settings(settings: CanSettings, error: BaseException) -> None:
    """Raise OdsError when trying again cannot help: unknown interface, bit rate or option."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, (ValueError, NotImplementedError, TypeError)):
            text = " ".join(str(error).split())
            raise OdsError(f"nav.can: {settings.interface} {settings.channel}: {text}") from error
        cause = cause.__cause__


def _enlarge(sock: socket.socket, size: int) -> None:
    """Set the receive buffer, beyond the system's limit where the process may."""
    so_rcvbufforce = 33
    try:
        sock.setsockopt(socket.SOL_SOCKET, so_rcvbufforce, size)
    except OSError:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, size)
