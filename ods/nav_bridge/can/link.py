"""The CAN interface: opened, read, and opened again when it fails or falls silent."""

import contextlib
import logging
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import can

from ods.base import clock
from ods.base.errors import OdsError, one_line, reason_of
from ods.nav_bridge.can.bus_errors import BusErrors
from ods.nav_bridge.can.frame import STANDARD_MASK, CanId, ErrorFrame, Frame
from ods.nav_bridge.can.python_can_bus import PythonCanBus
from ods.nav_bridge.can.slcan_bus import SlcanBus
from ods.nav_bridge.can.socketcan_bus import SocketcanBus
from ods.nav_bridge.can.stamp_clock import StampClock
from ods.nav_bridge.link import Descriptor, Link
from ods.nav_bridge.settings import CanSettings
from ods.runtime.port.backoff import Backoff

log = logging.getLogger(__name__)

READ_LIMIT = 512
"""Frames read in one go, so that a flood leaves time for the rest of the loop."""
SEND_TIMEOUT_S = 0.02
FIRST_RETRY_S, LAST_RETRY_S = 0.1, 1.0
IFF_UP = 1
FailedBus = (can.CanError, OSError)
AnyBus = SocketcanBus | SlcanBus | PythonCanBus


class CanLink(Link[Frame]):
    """One CAN interface, kept open.

    `closing` comes before that descriptor is closed. Counts `can_opened`, `can_lost`, `can_silent`, `can_unsent`, and
    what `BusErrors`, `StampClock` and the buses count.
    """

    def __init__(
        self,
        settings: CanSettings,
        ids: Iterable[CanId],
        counters: Counter[str],
        opened: Descriptor,
        closing: Descriptor,
    ) -> None:
        self._settings = settings
        self._ids = sorted(ids)
        self._counters = counters
        self._opened, self._closing = opened, closing
        self._silence_ns = round(settings.silence_s * clock.NS)
        self._errors = BusErrors(counters)
        self._stamps = StampClock(counters)
        self._bus: AnyBus | None = None
        self._fd: int | None = None
        self._why = "not open yet"
        self._said = ""
        self._retry_ns = 0
        self._backoff = Backoff(FIRST_RETRY_S, LAST_RETRY_S)
        self._received_ns = clock.monotonic_ns()
        self._opened_ns = 0

    @property
    def is_open(self) -> bool:
        """Return whether the interface is open."""
        return self._bus is not None

    def tick(self) -> None:
        """Open the interface when it is due, give it up when it is silent. Raises OdsError for bad settings."""
        now_ns = clock.monotonic_ns()
        if self._bus is not None and now_ns - max(self._received_ns, self._opened_ns) > self._silence_ns:
            self._counters["can_silent"] += 1
            self.close()
            self._retry_ns = now_ns
        if self._bus is None and now_ns >= self._retry_ns:
            self._open(now_ns)

    def read(self, woken_ns: int) -> Iterator[Frame]:
        """Yield the data frames that have arrived; `woken_ns`: when the first of them came, if nothing stamps them."""
        if self._bus is None:
            return
        count = 0
        try:
            for received in self._bus.receive(READ_LIMIT, woken_ns):
                count += 1
                if isinstance(received, ErrorFrame):
                    self._errors.take(received)
                else:
                    self._take_note(received.t_ns)
                    yield received
        except FailedBus as error:
            self._lost(error)
        if count < READ_LIMIT:
            self._stamps.emptied()

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
        """Return the problems of the interface, a text each."""
        now_ns = clock.monotonic_ns()
        found = [*self._errors.problems(now_ns), *self._complaints(now_ns)]
        return [f"{self._settings.channel}: {problem}" for problem in found]

    def _complaints(self, now_ns: int) -> Iterator[str]:
        silent_ns = now_ns - self._received_ns
        if self._bus is None:
            yield self._why
        elif self._settings.interface == "socketcan" and not _is_up(self._settings.channel):
            yield "is down"
        elif silent_ns > self._silence_ns:
            yield f"no CAN frame for {silent_ns / clock.NS:.1f} s"

    def close(self) -> None:
        """Close the interface."""
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
        self._stamps.emptied()
        try:
            self._bus = self._new_bus()
        except (*FailedBus, ValueError, NotImplementedError, TypeError) as error:
            if not self._opened_ns:  # it has worked with these settings otherwise
                _refuse_bad_settings(self._settings, error)
            self._try_later(error)
            return
        self._counters["can_opened"] += 1
        self._opened_ns = now_ns
        with contextlib.suppress(NotImplementedError):  # `virtual` has no descriptor: its owner polls
            self._fd = self._bus.fileno()
        self._opened(self._fd)

    def _new_bus(self) -> AnyBus:
        settings, counters = self._settings, self._counters
        options: dict[str, Any] = {} if settings.bitrate is None else {"bitrate": settings.bitrate}
        if settings.interface == "slcan":
            return SlcanBus(settings.channel, counters, **options | settings.options)
        if settings.interface != "socketcan":
            bus = can.Bus(settings.channel, settings.interface, ignore_config=True, **options | settings.options)
            return PythonCanBus(bus, self._stamps, counters)
        options["can_filters"] = [  # the kernel filters at no cost; elsewhere python-can would, slowly
            {"can_id": wanted.number, "can_mask": _mask(wanted), "extended": wanted.extended} for wanted in self._ids
        ]
        size = settings.receive_buffer_bytes
        return SocketcanBus(settings.channel, self._stamps, counters, size, **options | settings.options)

    def _lost(self, error: Exception) -> None:
        self._counters["can_lost"] += 1
        self._errors.lost()
        self.close()
        self._try_later(error)

    def _try_later(self, error: Exception) -> None:
        """Wait longer each time until a frame is received; say the reason once."""
        self._why = reason_of(error)
        self._retry_ns = clock.monotonic_ns() + round(self._backoff.failed() * clock.NS)
        if self._why != self._said:
            self._said = self._why
            log.warning("%s: %s; trying again", self._settings.channel, self._why)

    def _take_note(self, arrival_ns: int) -> None:
        self._received_ns = arrival_ns
        self._errors.works()
        self._backoff.worked()
        if self._said:
            self._said = ""
            log.info("%s: frames arrive again", self._settings.channel)


def _mask(wanted: CanId) -> int:
    return wanted.mask if wanted.extended else STANDARD_MASK


def _is_up(channel: str) -> bool:
    """Return whether a network interface is set up; a socket opens on one that is down, too."""
    try:
        flags = int((Path("/sys/class/net") / channel / "flags").read_text(), 16)
    except (OSError, ValueError):
        return True  # gone: reading reports it
    return bool(flags & IFF_UP)


def _refuse_bad_settings(settings: CanSettings, error: BaseException) -> None:
    """Raise OdsError when trying again cannot help: unknown interface, bit rate or option."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, (ValueError, NotImplementedError, TypeError)):
            raise OdsError(f"nav.can: {settings.interface} {settings.channel}: {one_line(error)}") from error
        cause = cause.__cause__
