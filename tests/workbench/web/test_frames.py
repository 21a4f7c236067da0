"""Frames: cells, pooling, the message on the wire, and who gets which frame when."""

import asyncio
import json
import math
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from starlette.websockets import WebSocket

from ods.workbench.web import frames
from ods.workbench.web.frames import Cells, Channel, Circle, Frame, FrameBoard, cells_of, encode, pooled

SCALE = (0.0, 51.0)
LONGEST_S = 10.0


def frame(samples: int = 8, number: int = 0, attended: bool = False) -> Frame:
    cells = np.random.default_rng(number).integers(0, 256, (3, samples), np.uint8)
    mask = cells > 128 if attended else None
    return Frame(
        cells, np.array([-0.5, 0.0, 0.5]), 1.0, 0.25, SCALE, (Circle(4.0, 0.25, 0.5),), (("high", 20.0),), mask
    )


def decoded(message: bytes) -> list[tuple[dict[str, object], Cells, Cells | None]]:
    """Read a message as its description says, with other code than that which wrote it."""
    length = int.from_bytes(message[:4], "little")
    rest = memoryview(message)[4 + length :]
    found = []
    for view in json.loads(message[4 : 4 + length])["views"]:
        size, shape = view["beams"] * view["cells"], (view["beams"], view["cells"])
        cells, rest = np.frombuffer(rest[:size], np.uint8).reshape(shape), rest[size:]
        attended = None
        if view["attention"]:
            attended, rest = np.frombuffer(rest[:size], np.uint8).reshape(shape), rest[size:]
        found.append((view, cells, attended))
    assert not rest
    return found


@given(samples=st.integers(1, 60), most=st.integers(-1, 70))
def test_pooling_loses_no_echo(samples: int, most: int) -> None:
    image = frame(samples).cells
    few = pooled(image, most)
    assert few.shape[1] <= max(1, most)
    window = math.ceil(samples / max(1, most))
    for beam, row in enumerate(image):
        assert few[beam].tolist() == [max(row[at : at + window]) for at in range(0, samples, window)]


def test_cells_are_levels_on_an_even_scale() -> None:
    level = np.array([[0.0, 10.0, 25.5, 51.0, -7.0, 90.0, np.nan, -np.inf, np.inf]], np.float32)
    assert cells_of(level, SCALE).tolist() == [[0, 50, 128, 255, 0, 255, 0, 0, 255]]


def test_a_message_says_all_of_its_frames() -> None:
    whole, coarse = frame(8, attended=True), frame(9, 1)
    (first, cells, attended), (second, few, none) = decoded(encode([("a", 100, whole), ("b", 4, coarse)]))
    assert (cells == whole.cells).all()
    assert attended is not None
    assert (attended.astype(bool) == (whole.cells > 128)).all()
    assert none is None
    assert few.shape == (3, 3)
    assert (second["pool"], second["samples"], first["pool"]) == (3, 9, 1)
    assert first["key"] == "a"
    assert first["version"] == whole.version != coarse.version == second["version"]
    assert first["circles"] == [[4.0, 0.25, 0.5, "detection"]]
    assert first["scale_db"] == [0.0, 51.0]
    assert first["bearing_rad"] == [-0.5, 0.0, 0.5]
    assert (first["range0_m"], first["dr_m"]) == (1.0, 0.25)


@pytest.fixture
def board() -> FrameBoard:
    return FrameBoard()


class Page:
    """A page's end of the WebSocket, without a network between: what ASGI says of it."""

    def __init__(self) -> None:
        self.to_server: asyncio.Queue[Any] = asyncio.Queue()
        self.to_page: asyncio.Queue[Any] = asyncio.Queue()

    def send(self, text: str) -> None:
        self.to_server.put_nowait({"type": "websocket.receive", "text": text})

    def ask(self, **have: int) -> None:
        self.send(json.dumps({"views": {key: {"have": version, "cells": 100} for key, version in have.items()}}))

    async def received(self) -> dict[str, Any]:
        message: dict[str, Any] = await asyncio.wait_for(self.to_page.get(), LONGEST_S)
        return message

    async def got(self) -> list[tuple[object, object]]:
        return [(view["key"], view["version"]) for view, _, _ in decoded((await self.received())["bytes"])]


@asynccontextmanager
async def connected() -> AsyncIterator[Page]:
    page = Page()
    page.to_server.put_nowait({"type": "websocket.connect"})
    socket = WebSocket({"type": "websocket"}, page.to_server.get, page.to_page.put)
    pulling = asyncio.create_task(frames.pull(socket))
    assert (await page.received())["type"] == "websocket.accept"
    yield page
    page.to_server.put_nowait({"type": "websocket.disconnect", "code": 1000})
    await asyncio.wait_for(pulling, LONGEST_S)


async def test_a_page_gets_the_newest_frame_and_none_twice(board: FrameBoard) -> None:
    channel = Channel(board, "fan")
    shown = [frame(number=number) for number in range(4)]
    async with connected() as page:
        board.show("fan", shown[0])
        page.ask(**{channel.key: 0})
        assert await page.got() == [(channel.key, shown[0].version)]
        for later in shown[1:3]:
            board.show("fan", later)
        page.ask(**{channel.key: shown[0].version})
        assert await page.got() == [(channel.key, shown[2].version)]
        page.ask(**{channel.key: shown[2].version})
        timer = threading.Timer(0.05, board.show, ("fan", shown[3]))  # while the page waits, from another thread
        timer.start()
        assert await page.got() == [(channel.key, shown[3].version)]
        timer.join()


async def test_a_view_can_be_switched_to_an_older_frame(board: FrameBoard) -> None:
    channel = Channel(board, "a")
    a, b = frame(), frame(number=1)
    board.show("a", a)
    board.show("b", b)
    async with connected() as page:
        page.ask(**{channel.key: 0})
        assert await page.got() == [(channel.key, a.version)]
        for view, wanted, have in (("b", b, a), ("a", a, b)):
            page.ask(**{channel.key: have.version})
            channel.switch(view)
            assert await page.got() == [(channel.key, wanted.version)]


async def test_views_of_one_page_come_together_and_those_of_nobody_never(board: FrameBoard) -> None:
    one, two, gone = Channel(board, "one"), Channel(board, "two"), Channel(board, "one").key
    for view in ("one", "two"):
        board.show(view, frame())
    async with connected() as page:
        page.ask(**{one.key: 0, two.key: 0, gone: 0, "made up": 0})
        assert {key for key, _ in await page.got()} == {one.key, two.key}


@pytest.mark.parametrize("text", ["", "{", '{"views": 3}', '{"views": {"a": {"have": 0}}}', '{"views": {}, "x": 1}'])
async def test_what_is_no_request_ends_the_connection(text: str) -> None:
    async with connected() as page:
        page.send(text)
        ended = await page.received()
    assert (ended["type"], ended["code"]) == ("websocket.close", frames.NOT_UNDERSTOOD)
