"""Sends set points on a CAN bus; opens it, and opens it again when it fails. It receives nothing there."""

import contextlib
import logging
from collections import Counter
from typing import Any

import can

from ods.base import clock
from ods.base.errors import reason_of
from ods.planner.set_point_pdo import pdo_of
from ods.planner.settings import PlannerCanSettings
from ods.runtime.port.backoff import Backoff

log = logging.getLogger(__name__)

SEND_TIMEOUT_S = 0.1
FIRST_RETRY_S, LAST_RETRY_S = 0.1, 1.0
FAILED = (can.CanError, OSError, ValueError)


class CanSender:
    """One interface. Counts `can_opened` and `can_unsent`."""

    def __init__(self, settings: PlannerCanSettings, counters: Counter[str]) -> None:
        """Raises OdsError for an EDS file without the RPDO."""
        self._settings, self._counters = settings, counters
        self._pdo = pdo_of(settings.eds, settings.node_id)
        self._bus: can.BusABC | None = None
        self._retry_ns = 0
        self._backoff = Backoff(FIRST_RETRY_S, LAST_RETRY_S)
        self.problem = ""

    def send(self, heading_rad: float, speed_m_s: float, down_m: float) -> None:
        """Send one; what cannot go out is counted and forgotten."""
        data = self._pdo.encode(heading_rad, speed_m_s, down_m)
        message = can.Message(arbitration_id=self._pdo.can_id, data=data, is_extended_id=False)
        try:
            self._open().send(message, timeout=SEND_TIMEOUT_S)
        except FAILED as error:
            self._counters["can_unsent"] += 1
            self._lost(reason_of(error))
            return
        self._backoff.worked()
        self.problem = ""

    def close(self) -> None:
        """Give the interface back."""
        bus, self._bus = self._bus, None
        if bus is not None:
            with contextlib.suppress(*FAILED):
                bus.shutdown()

    def _open(self) -> can.BusABC:
        """Raises one of FAILED."""
        if self._bus is None:
            if clock.monotonic_ns() < self._retry_ns:
                raise OSError(self.problem)
            options: dict[str, Any] = {"sleep_after_open": 0.0} if self._settings.interface == "slcan" else {}
            self._bus = can.Bus(self._settings.channel, self._settings.interface, ignore_config=True, **options)
            self._counters["can_opened"] += 1
        return self._bus

    def _lost(self, why: str) -> None:
        now_ns = clock.monotonic_ns()
        self.close()
        if now_ns >= self._retry_ns:
            self._retry_ns = now_ns + round(self._backoff.failed() * clock.NS)
        if not self.problem:
            log.warning("%s: %s; trying again", self._settings.channel, why)
        self.problem = why
