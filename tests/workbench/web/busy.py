"""A workbench that is hard to stop: a thread changes its page, also as it ends, or work in a thread never ends."""

import asyncio
import sys
import threading
import time
from functools import partial
from itertools import count

from nicegui import background_tasks, run, ui

from ods.workbench.session import Session
from ods.workbench.web import server
from ods.workbench.web.follow import in_loop

PAUSE_S = 0.05


def stream(session: Session) -> None:
    """Build a label that a thread changes."""
    label = ui.label(f"session {session.number}")
    _labels.append(label)

    def deliver() -> None:
        for number in count():
            in_loop(label, partial(label.set_text, str(number)))
            time.sleep(PAUSE_S)

    threading.Thread(target=deliver, daemon=True).start()


async def teardown() -> None:
    """Cancel NiceGUI's tasks just as the pages change."""
    for label in _labels:
        label.set_text("ending")
    await _teardown()


_teardown = background_tasks.teardown
_labels: list[ui.label] = []


def stuck(_: Session) -> None:
    """Build a page of which work hangs, in both kinds of threads that pages use."""
    for begin in (lambda: asyncio.to_thread(hang), lambda: run.io_bound(hang)):
        ui.timer(0.0, begin, once=True)


def hang() -> None:
    """Wait for what never comes, as reading a disk of a computer that is gone does."""
    print("hangs", flush=True)
    threading.Event().wait()


def main() -> None:
    """Serve it."""
    background_tasks.teardown = teardown
    build = {"stream": stream, "stuck": stuck}[sys.argv[1]]
    server.serve(server.Site(build, Session), server.listening(0), lambda link: print(link, flush=True))


if __name__ == "__main__":
    main()
