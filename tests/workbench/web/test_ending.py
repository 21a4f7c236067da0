"""A server that is asked to stop ends soon, whatever its pages and their threads do."""

import asyncio
import re
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from itertools import count
from uuid import uuid4

import msgspec
import pytest
from nicegui import ui

from ods.workbench.web.ending import LONGEST_S
from ods.workbench.web.follow import in_loop
from tests.workbench.pages.visiting import simulated
from tests.workbench.serving import Serving, serving

SOCKET = "/_nicegui_ws/socket.io/"


@contextmanager
def visited(server: Serving) -> Iterator[None]:
    """Open the page and connect its Socket.IO, by long polling, as a browser behind a proxy does."""
    with closing(server.client()) as browser:
        browser.timeout = 60.0  # s, of a busy machine
        found = re.search(r"'client_id': '([0-9a-f-]+)'", browser.get("/").text)
        assert found
        query = {"EIO": "4", "transport": "polling"}
        query["sid"] = msgspec.json.decode(browser.get(SOCKET, params=query).text[1:])["sid"]
        hello = {"client_id": found[1], "tab_id": str(uuid4()), "document_id": str(uuid4())}
        for packet in ("40", "42" + msgspec.json.encode(["handshake", hello]).decode()):
            assert browser.post(SOCKET, params=query, content=packet).text == "OK"
        assert browser.get(SOCKET, params=query).text.startswith("40")
        yield


def test_a_page_that_changes_as_it_ends_does_not_hold_it_up() -> None:
    """NiceGUI's loop of a page misses a cancellation that comes with a change."""
    with serving("stream", module="tests.workbench.web.busy") as server, visited(server):
        time.sleep(0.5)  # its loop has sent what there was, and waits
        server.process.send_signal(signal.SIGTERM)
        server.process.wait(timeout=3.0 * LONGEST_S)
        assert server.process.stdout is not None
        said = server.process.stdout.read()
    assert "Could not cancel" not in said
    assert "not ended" not in said


async def test_a_thread_that_changes_the_page_all_the_time_does_not_hold_it_up(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """If two cancellations come with a change, the loop of the page never ends by itself."""
    ends = threading.Event()

    def build() -> None:
        label = ui.label()

        def deliver() -> None:
            for number in count():
                in_loop(label, partial(label.set_text, str(number)))
                if ends.wait(0.0005):
                    return

        threading.Thread(target=deliver, daemon=True).start()

    try:
        async with asyncio.timeout(60.0), simulated(build) as user:
            await user.open("/")
            await asyncio.sleep(0.3)
    finally:
        ends.set()
    assert "Could not cancel" not in caplog.text


def test_work_that_hangs_in_a_thread_ends_with_it_and_is_named() -> None:
    with serving("stuck", module="tests.workbench.web.busy") as server, visited(server):
        while server.line() != "hangs\n":  # but a link for the next browser
            pass
        assert server.line() == "hangs\n"
        server.process.send_signal(signal.SIGINT)  # by default SIGTERM ends a process without waiting for its threads
        server.process.wait(timeout=3.0 * LONGEST_S)
        assert server.process.stdout is not None
        said = server.process.stdout.read()
    assert server.process.returncode == 1
    assert f"not ended within {LONGEST_S:.0f} s, so it was ended; still at work: " in said
    assert "tests/workbench/web/busy.py" in said
