"""python-can's slcan bus with a reader of its own: whole bursts in one go, and garbage dropped line by line.

python-can reads byte by byte, three system calls each, which costs 11 % of a core at 600 frames/s.
"""

import errno
import os
import re
import select
from binascii import unhexlify
from collections import Counter
from collections.abc import Iterator
from typing import Any

import can
from can.interfaces.slcan import slcanBus

from ods.nav_bridge.can.frame import Frame

CR, BELL = b"\r", b"\a"
FRAME = re.compile(rb"(?:[tr]([0-7][0-9A-F]{2})|[TR]([01][0-9A-F]{7}))([0-8])((?:[0-9A-F]{2})*)", re.IGNORECASE)
ANSWER = re.compile(rb"[zZ]?|[VvNF][0-9A-Za-z]*")
"""What adapters say beside frames: acknowledgements, versions, status."""
MAX_LINE = 64
WRITE_TIMEOUT_S = 0.1
REMOTE_TYPES = b"rR"


def parse(line: bytes, t_ns: int) -> Frame | None:
    """Return the frame of an slcan (LAWICEL) line without its carriage return, None when it is malformed.

    A remote frame counts as one without data. A time stamp of the adapter behind the data is ignored.
    """
    match = FRAME.fullmatch(line)
    if match is None:
        return None
    standard, extended, length, digits = match.groups()
    wanted = 0 if line[0] in REMOTE_TYPES else 2 * int(length)
    if len(digits) < wanted:
        return None
    return Frame(int(standard or extended, 16), standard is None, unhexlify(digits[:wanted]), t_ns)


class SlcanBus(slcanBus):
    """An slcan adapter. Counts `can_garbage` (lines neither frame nor answer) and `can_ignored` (remote frames)."""

    def __init__(self, channel: str, counters: Counter[str], **options: Any) -> None:
        self._counters = counters
        self._rest = b""
        super().__init__(channel, **{"sleep_after_open": 0.0, "timeout": 0.0} | options)

    def receive(self, limit: int, woken_ns: int) -> Iterator[Frame]:
        """Yield what is waiting, `limit` frames or a little more, stamped `woken_ns`. Never waits.

        Raises CanOperationError.
        """
        *lines, self._rest = (self._rest + self._read_bytes(limit * MAX_LINE)).split(CR)
        if len(self._rest) > MAX_LINE:
            lines, self._rest = [*lines, self._rest], b""
        for answered in lines:
            line = answered.lstrip(BELL)
            frame = parse(line, woken_ns)
            if frame is None:
                self._counters["can_garbage"] += not ANSWER.fullmatch(line)
            elif line[0] in REMOTE_TYPES:
                self._counters["can_ignored"] += 1
            else:
                yield frame

    def _write(self, string: str) -> None:
        """Write as python-can does, but not for ever: an adapter may stop taking bytes."""
        if self.serialPortOrig.write_timeout != WRITE_TIMEOUT_S:
            self.serialPortOrig.write_timeout = WRITE_TIMEOUT_S
        super()._write(string)

    def _read_bytes(self, limit: int) -> bytes:
        """Return what has arrived. pyserial does the same with three system calls instead of one."""
        fd = self.fileno()
        try:
            data = os.read(fd, limit)
            if data or not select.select([fd], [], [], 0.0)[0]:
                return data
            data = os.read(fd, limit)  # may have come meanwhile
            if not data:
                raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
        except OSError as error:
            raise can.CanOperationError("cannot read from the serial device") from error
        return data
