"""python-can's slcan bus with a reader of its own: whole bursts in one go, and garbage dropped line by line.

python-can reads byte by byte, three system calls each, which costs 11 % of a core at 600 frames/s.
"""

import errno
import os
import re
import select
from collections import Counter, deque
from typing import Any

import can
from can.interfaces.slcan import slcanBus

from ods import clock

CR, BELL = b"\r", b"\a"
FRAME = re.compile(rb"(?:([tr])([0-7][0-9A-F]{2})|([TR])([01][0-9A-F]{7}))([0-8])((?:[0-9A-F]{2})*)", re.IGNORECASE)
ANSWER = re.compile(rb"[zZ]?|[VvNF][0-9A-Za-z]*")
"""What adapters say beside frames: acknowledgements, versions, status."""
MAX_LINE = 64
READ_BYTES = 65536


def parse(line: bytes) -> can.Message | None:
    """Return the frame of an slcan (LAWICEL) line without its carriage return, None when it is none.

    A time stamp of the adapter behind the data is ignored.
    """
    match = FRAME.fullmatch(line)
    if match is None:
        return None
    kind, length = match[1] or match[3], int(match[5])
    remote = kind in b"rR"
    if not remote and len(match[6]) < 2 * length:
        return None
    return can.Message(
        timestamp=clock.utc_ns() / clock.NS,
        arbitration_id=int(match[2] or match[4], 16),
        is_extended_id=kind in b"TR",
        is_remote_frame=remote,
        dlc=length,
        data=b"" if remote else bytes.fromhex(match[6][: 2 * length].decode()),
    )


class SlcanBus(slcanBus):
    """An slcan adapter; `recv` never waits. Counts `can_garbage`: lines that are neither frame nor answer."""

    def __init__(self, channel: str, counters: Counter[str], **options: Any) -> None:
        self._counters = counters
        self._rest = b""
        self._lines: deque[bytes] = deque()
        super().__init__(channel, **{"sleep_after_open": 0.0, "timeout": 0.0} | options)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        while self._lines or self._read_lines():
            line = self._lines.popleft().lstrip(BELL)
            message = parse(line)
            if message is not None:
                return message, False
            if not ANSWER.fullmatch(line):
                self._counters["can_garbage"] += 1
        return None, False

    def _read_lines(self) -> bool:
        """Read all that has arrived; tell whether whole lines are waiting."""
        *lines, self._rest = (self._rest + self._read_bytes()).split(CR)
        if len(self._rest) > MAX_LINE:
            lines, self._rest = [*lines, self._rest], b""
        self._lines.extend(lines)
        return bool(lines)

    def _read_bytes(self) -> bytes:
        """Return what has arrived. pyserial does the same with three system calls instead of one."""
        fd = self.fileno()
        try:
            data = os.read(fd, READ_BYTES)
            if data or not select.select([fd], [], [], 0.0)[0]:
                return data
            data = os.read(fd, READ_BYTES)  # may have come meanwhile
            if not data:
                raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
        except OSError as error:
            raise can.CanOperationError("cannot read from the serial device") from error
        return data
