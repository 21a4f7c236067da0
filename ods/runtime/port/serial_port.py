"""The sonar's serial line, as a port that may be unplugged and plugged in again."""

import contextlib
import os
import time
from collections import Counter
from pathlib import Path
from typing import Any

import serial

from ods.runtime.port.port import ERRORS, PORT_READ_BYTES, Port, PortError

BREAK_S = 0.001


class SerialPort(Port):
    """One serial device, by its path."""

    def __init__(
        self,
        port: str,
        baud: int,
        pauses_s: tuple[float, float],
        counters: "Counter[str] | None" = None,
        wake: bytes = b"",
    ) -> None:
        """Make a closed port; pauses_s: shortest and longest pause before it is tried again.

        wake: sent behind a break when it has been opened, to a device that finds its rate by that; b"": no break.
        """
        super().__init__(port, pauses_s, counters)
        self._baud = baud
        self._wake = wake
        self._port: Any = None  # pyserial has no types

    def _descriptor(self) -> int:
        return int(self._port.fileno())

    def _begin_opening(self, _now_ns: int) -> None:
        self._port = serial.Serial(self._name, baudrate=self._baud, timeout=0, exclusive=True)
        if self._wake:
            with contextlib.suppress(*ERRORS):  # a pseudo-terminal has no breaks
                self._port.break_condition = True
            time.sleep(BREAK_S)
            with contextlib.suppress(*ERRORS):
                self._port.break_condition = False
            time.sleep(BREAK_S)
            os.write(self._descriptor(), self._wake)

    def _receive(self) -> bytes:
        return bytes(self._port.read(PORT_READ_BYTES))

    def _send(self, data: bytes) -> int:
        return os.write(self._descriptor(), data)  # pyserial's own write() spins while the line takes nothing

    def _examine(self, _now_ns: int) -> None:
        """Raise when the device has gone, or its path leads to another device now."""
        if not os.path.samestat(Path(self._name).stat(), os.fstat(self._descriptor())):
            raise PortError("the device was replaced")

    def _release(self) -> None:
        if self._port is not None:
            self._port.close()
            self._port = None
