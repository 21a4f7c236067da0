"""A page of the workbench in NiceGUI's simulated browser."""

import asyncio
import base64
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

os.environ.setdefault("NICEGUI_STORAGE_PATH", f"{os.devnull}/none")  # read when NiceGUI is imported

import numpy as np
from nicegui.testing import User, user_simulation

from ods.workbench.session import Session
from ods.workbench.web.ending import stop_outboxes


@asynccontextmanager
async def simulated(build: Callable[[], None]) -> AsyncIterator[User]:
    """Serve a page to a simulated browser, and end as the server does."""
    async with user_simulation(build) as user:
        try:
            yield user
        finally:
            stop_outboxes()


@asynccontextmanager
async def visiting(session: Session, build: Callable[[Session], None]) -> AsyncIterator[User]:
    """Open a page of one menu."""
    async with simulated(lambda: build(session)) as user:
        await user.open("/")
        yield user


async def until(true: Callable[[], object], seconds: float = 240.0) -> None:
    """Wait for something that happens in the background."""
    for _ in range(round(seconds / 0.05)):
        if true():
            return
        await asyncio.sleep(0.05)
    raise AssertionError("it never came true")


def numbers(text: str) -> list[float]:
    """Read what a chart's script is given, as it does."""
    read: list[float] = np.frombuffer(base64.b64decode(text), "<f4").tolist()
    return read
