"""The end of the server: in bounded time, whatever pages and their threads do.

Two things would hold it up. NiceGUI's loop of a page waits with `asyncio.wait_for`, which up to Python 3.11 returns
normally where a cancellation comes together with what it waits for, here a change of the page: the loop goes on, and
NiceGUI's wait for its end, another `wait_for`, has no limit if that happens twice. And asyncio and the interpreter wait
without a limit for work that hangs in a thread, such as reading a disk of a computer that is gone.
"""

import multiprocessing
import os
import sys
import threading
from pathlib import Path
from types import FrameType

import uvicorn
from nicegui import Client

LONGEST_S = 10.0
"""From the signal until the process is ended by force; what is written in a process of its own has 5 s of these."""
LIBRARIES = Path(uvicorn.__file__).parents[1], Path(threading.__file__).parent
"""Folders whose functions say little of what hangs."""


def stop_outboxes() -> None:
    """Let the loops of all pages end by themselves with their next turn, also one that misses its cancellation."""
    for client in list(Client.instances.values()):
        client.outbox.stop()


class Server(uvicorn.Server):
    """Ends the process by force if it has not ended `LONGEST_S` after the first signal."""

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Begin to end."""
        if not self.should_exit:
            limit = threading.Timer(LONGEST_S, _end_by_force)
            limit.daemon = True
            limit.start()
        super().handle_exit(sig, frame)


def _end_by_force() -> None:
    places = ", ".join(_at_work()) or "nothing of ODS"
    print(
        f"ods workbench: not ended within {LONGEST_S:.0f} s, so it was ended; still at work: {places}",
        file=sys.stderr, flush=True,
    )  # fmt: skip
    for process in multiprocessing.active_children():
        process.kill()
    os._exit(1)


def _at_work() -> list[str]:
    """Return where the threads are that the interpreter would wait for: file, line and function of each."""
    frames = sys._current_frames()
    return [
        place
        for thread in threading.enumerate()
        if not thread.daemon and thread.ident in frames and (place := _place(frames[thread.ident]))
    ]


def _place(innermost: FrameType) -> str:
    """Return the innermost place that is no library's; "" where there is none, as in a thread that waits for work."""
    frame: FrameType | None = innermost
    while frame is not None:
        file = Path(frame.f_code.co_filename)
        if not any(file.is_relative_to(folder) for folder in LIBRARIES):
            return f"{file}:{frame.f_lineno} {frame.f_code.co_name}"
        frame = frame.f_back
    return ""
