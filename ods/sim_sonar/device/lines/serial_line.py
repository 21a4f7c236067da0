"""The far end of a virtual serial line: a pseudo-terminal that can be unplugged and plugged in again."""

import contextlib
import os
import select
import time
import tty
from pathlib import Path


class SerialLine:
    """A pty whose device name stands behind the symlink `link`.

    Bytes that nobody reads are lost, as on a real line.
    """

    needs_subscription = False
    connections = 0

    def __init__(self, link: Path) -> None:
        self._link = link
        self._master = -1
        self._slave = -1
        self.lost_bytes = 0
        self.plug()

    def plug(self) -> None:
        """Make the device and its link appear."""
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self._link.parent.mkdir(parents=True, exist_ok=True)
        self._link.unlink(missing_ok=True)
        self._link.symlink_to(os.ttyname(self._slave))

    def unplug(self) -> None:
        """Make the device and its link vanish."""
        self._link.unlink(missing_ok=True)
        for fd in (self._slave, self._master):
            if fd >= 0:
                os.close(fd)
        self._master = self._slave = -1

    def write(self, records: list[bytes], patience_s: float) -> bool:
        """Write all `records`; give up, and count what is lost, when the reader takes longer than `patience_s`."""
        view = memoryview(b"".join(records))
        deadline_s = time.monotonic() + patience_s
        while view and self._master >= 0 and time.monotonic() < deadline_s:
            with contextlib.suppress(BlockingIOError):
                view = view[os.write(self._master, view) :]
                continue
            select.select([], [self._master], [], max(0.0, deadline_s - time.monotonic()))
        self.lost_bytes += len(view)
        return not view

    def read(self) -> bytes:
        """Return what the other end has written, b'' when nothing."""
        if self._master < 0:
            return b""
        try:
            return os.read(self._master, 65536)
        except OSError:
            return b""
