"""A guest that boots a disk image by User-mode Linux, with systemd as its first process, and obeys the tests."""

import contextlib
import json
import os
import select
import threading
import time
from pathlib import Path
from typing import Any

from in_vcan.keeper import keep
from in_vcan.uml import Kernel

BOOT_S = 120.0
LIFE_S = 3600.0
MEMORY_MB = 1536


class GuestEndedError(AssertionError):
    """The guest is off, or its kernel died."""


class Guest:
    """One computer: it can be switched on, asked, and shut down, again and again."""

    def __init__(self, kernel: Kernel, folder: Path) -> None:
        """`folder` holds the `disk`, and gets what the guest's consoles say."""
        self._kernel = kernel
        self._folder = folder
        self._boots = 0
        self._kept: threading.Thread | None = None
        self._to_guest = self._from_guest = -1
        self._read = b""

    def switch_on(self) -> None:
        """Boot; return when commands can be given."""
        self._boots += 1
        theirs_in, self._to_guest = os.pipe()
        self._from_guest, theirs_out = os.pipe()
        sockets = self._folder / f"uml-{self._boots}"
        sockets.mkdir()
        words = [
            *self._kernel.words(sockets, MEMORY_MB),
            *(f"ubd0={self._folder}/disk", "root=/dev/ubda", "rw", "init=/lib/systemd/systemd"),
            *("con=null", "con0=null,fd:1", f"ssl1=fd:{theirs_in},fd:{theirs_out}"),
        ]
        self._kept = threading.Thread(target=self._keep, args=(words, (theirs_in, theirs_out)), daemon=True)
        self._kept.start()
        assert self._line(BOOT_S) == b"up", "the guest did not get up"

    def _keep(self, words: list[str], fds: tuple[int, int]) -> None:
        with (self._folder / f"console-{self._boots}").open("wb") as console:
            keep(words, LIFE_S, [], stdout=console, pass_fds=fds)
        for fd in fds:
            os.close(fd)

    def ask(self, *command: str, user: str = "", timeout_s: float = 60.0) -> tuple[int, str]:
        """Run a command in the guest, as root or as another user; return its exit status and all that it printed."""
        as_user = ["runuser", "-u", user, "--"] if user else []
        request: dict[str, Any] = {"command": [*as_user, *command], "timeout_s": timeout_s}
        os.write(self._to_guest, json.dumps(request).encode() + b"\n")
        answer = json.loads(self._line(timeout_s + 30.0))
        return answer["status"], answer["output"].strip()

    def run(self, *command: str, user: str = "", timeout_s: float = 60.0) -> str:
        """Run a command that must not fail; return what it printed."""
        status, output = self.ask(*command, user=user, timeout_s=timeout_s)
        assert status == 0, f"{' '.join(command)}: status {status}: {output}"
        return output

    def shut_down(self) -> None:
        """Let systemd stop everything and switch off."""
        if self._kept is not None and self._kept.is_alive():
            with contextlib.suppress(GuestEndedError):  # it may be off before it can answer
                self.ask("systemctl", "poweroff")
            self._kept.join(BOOT_S)
            assert not self._kept.is_alive(), "the guest does not switch off"

    def _line(self, timeout_s: float) -> bytes:
        end_s = time.monotonic() + timeout_s
        while b"\n" not in self._read:
            ready = select.select([self._from_guest], [], [], max(0.0, end_s - time.monotonic()))[0]
            assert ready, f"no word of the guest within {timeout_s} s: {self._read!r}"
            data = os.read(self._from_guest, 65536)
            if not data:
                raise GuestEndedError("the guest has ended")
            self._read += data
        line, _, self._read = self._read.partition(b"\n")
        return line
