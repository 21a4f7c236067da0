"""A serial port that may vanish and come back: non-blocking reads, and reopening as a small state machine.

Closed -> (pause over, device there) -> open -> (read error, end of file, device gone or replaced) -> closed. The pause
doubles with every failure, up to a limit, until data have come. No clock and no thread: the caller tells the time and
polls `fd`.
"""

import errno
import os
import termios
from collections import Counter
from pathlib import Path

import serial

NS = 1_000_000_000
READ_BYTES = 65536


class SerialPort:
    """One port, by device path or pyserial URL. Counters: port_opens, port_losses, port_open_errors."""

    def __init__(
        self, port: str, baud: int, pauses_s: tuple[float, float], counters: "Counter[str] | None" = None
    ) -> None:
        """Make a closed port; pauses_s: shortest and longest pause before it is tried again."""
        self.counters: Counter[str] = Counter() if counters is None else counters
        self.fault = f"{port}: not opened yet"
        """Why the port is closed, in plain words; '' when it is open."""
        self._name = port
        self._baud = baud
        self._pauses_ns = round(pauses_s[0] * NS), round(pauses_s[1] * NS)
        self._pause_ns = self._pauses_ns[0]
        self._due_ns = 0
        self._port: serial.SerialBase | None = None

    @property
    def fd(self) -> int | None:
        """The descriptor to poll, None when closed."""
        return None if self._port is None else int(self._port.fileno())

    def open_if_due(self, now_ns: int) -> bool:
        """Try to open a closed port whose pause is over; tell whether it is open now and was not before."""
        if self._port is not None or now_ns < self._due_ns:
            return False
        try:
            self._port = serial.serial_for_url(self._name, baudrate=self._baud, timeout=0, exclusive=True)
        except (OSError, ValueError, termios.error) as error:
            self.counters["port_open_errors"] += 1
            self._wait(now_ns, f"{self._name}: {_in_plain_words(error)}")
            return False
        self.counters["port_opens"] += 1
        self.fault = ""
        return True

    def read(self, now_ns: int) -> bytes:
        """Return what has come, at most READ_BYTES; b'' when nothing has, or when the port was lost (`fd` is None)."""
        if self._port is None:
            return b""
        try:
            data = bytes(self._port.read(READ_BYTES))
        except (OSError, termios.error) as error:
            self._lose(now_ns, _in_plain_words(error))
            return b""
        if data:
            self._pause_ns = self._pauses_ns[0]
        return data

    def check(self, now_ns: int) -> None:
        """Give the port up if its device has gone, or its path leads to another device now."""
        fd = self.fd
        if fd is None or "://" in self._name:
            return
        try:
            same = os.path.samestat(Path(self._name).stat(), os.fstat(fd))
        except OSError as error:
            self._lose(now_ns, _in_plain_words(error))
        else:
            if not same:
                self._lose(now_ns, "the device was replaced")

    def close(self) -> None:
        """Give the port back."""
        if self._port is not None:
            self._port.close()
            self._port = None

    def _lose(self, now_ns: int, reason: str) -> None:
        self.counters["port_losses"] += 1
        self.close()
        self._wait(now_ns, f"{self._name}: {reason}")

    def _wait(self, now_ns: int, fault: str) -> None:
        self.fault = fault
        self._due_ns = now_ns + self._pause_ns
        self._pause_ns = min(2 * self._pause_ns, self._pauses_ns[1])


def _in_plain_words(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == errno.EAGAIN:
        return "in use by another program"
    if number:
        text = os.strerror(number)
        return text[:1].lower() + text[1:]
    return str(error)
