"""The sonar's serial line, as a port that may be unplugged and plugged in again."""

import os
from collections import Counter
from pathlib import Path
from typing import Any

import serial

from ods.runtime.port.port import PORT_READ_BYTES, Port, PortError


class SerialPort(Port):
    """One serial device, by its path."""

    def __init__(
        self, port: str, baud: int, pauses_s: tuple[float, float], counters: "Counter[str] | None" = None
    ) -> None:
        """Make a closed port; pauses_s: shortest and longest pause before it is tried again."""
        super().__init__(port, pauses_s, counters)
        self._baud = baud
        self._port: Any = None  # pyserial has no types

    def _descriptor(self) -> int:
        return int(self._port.fileno())

    def _begin_opening(self, _now_ns: int) -> None:
        self._port = serial.Serial(self._name, baudrate=self._baud, timeout=0, exclusive=True)

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
