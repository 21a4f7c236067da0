"""Sonar images to the browser: uint8, pulled by the page over a WebSocket of its own, so that none ever queue up.

A page's script sends what it has and how finely it can draw, `Request` as JSON; once something else is to be seen there
it gets one binary message: length of the header (4 bytes, little-endian), header (JSON: `{"views": [...]}`, each as
`_header` writes it), then for each view its cells and, where there is one, its attention: (beams, cells) bytes each.
"""

import asyncio
import contextlib
import itertools
import secrets
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol
from weakref import WeakSet, WeakValueDictionary

import msgspec
import numpy as np
import numpy.typing as npt
from starlette.websockets import WebSocket, WebSocketDisconnect

from ods.base.arrays import Floats, Floats32, Mask

Cells = npt.NDArray[np.uint8]
Kind = Literal["detection", "right", "false", "missed", "only_a", "only_b", "truth", "track"]
MOST_CELLS = 4096
"""Range cells of a beam that a page may ask for."""
NOT_UNDERSTOOD = 1003
"""WebSocket's code for a message that cannot be taken."""
LabelBox = tuple[int, int, int, int, str, str]
"""First and last beam, first and last sample, shape (rectangle or ellipse), text."""
new_version: Callable[[], int] = itertools.count(1).__next__
"""Return a number that no other picture of this program has."""


class Circle(NamedTuple):
    """Something round in the image: a detection, or what is known to be there."""

    range_m: float
    bearing_rad: float
    radius_m: float
    kind: Kind = "detection"


@dataclass(frozen=True, eq=False)
class Frame:
    """One image as a view shows it. Not to be changed any more once it was given away."""

    cells: Cells
    """(beams, samples): 0 stands for the first of `scale_db`, 255 for the second, evenly between."""
    bearing_rad: Floats
    """(beams,) rising, positive to starboard."""
    range0_m: float
    """Of the first sample's centre."""
    dr_m: float
    scale_db: tuple[float, float]
    """Levels of cell 0 and 255, dB."""
    circles: tuple[Circle, ...] = ()
    thresholds_db: tuple[tuple[str, float], ...] = ()
    """Name and level of each, shown at the colour scale."""
    attended: Mask | None = None
    """(beams, samples): False where this ping was not looked at."""
    caption: str = ""
    """One line over the image."""
    labels: tuple[LabelBox, ...] = ()
    """That a person drew."""
    version: int = field(default_factory=new_version)
    """Another for each frame of this program."""

    def header(self) -> dict[str, Any]:
        """Return what the fan view gets besides the cells."""
        return {
            "range0_m": self.range0_m,
            "dr_m": self.dr_m,
            "bearing_rad": [round(float(bearing), 6) for bearing in self.bearing_rad],
            "scale_db": self.scale_db,
            "circles": self.circles,
            "thresholds_db": self.thresholds_db,
            "labels": self.labels,
            "caption": self.caption,
        }


class Picture(Protocol):
    """What goes to a view: a `Frame`, or an image of another kind."""

    @property
    def cells(self) -> Cells:
        """(beams, samples); in the range of samples the highest may stand for its neighbours."""

    @property
    def attended(self) -> Mask | None:
        """Of the same shape, if there is one."""

    @property
    def version(self) -> int:
        """From `new_version`."""

    def header(self) -> dict[str, Any]:
        """Return what the view gets besides the cells, as JSON."""


class FrameSource(Protocol):
    """What a page implements to show images; `FrameBoard` is one that suits most."""

    def latest(self, view: str) -> Picture | None:
        """Return what a view shows now, at once. Called in the server's loop; call `wake` when it becomes another."""
        ...


class FrameBoard:
    """The newest frame of each view, by name. Any thread may show one."""

    def __init__(self) -> None:
        self._frames: dict[str, Frame] = {}

    def show(self, view: str, frame: Frame) -> None:
        """Show a frame from now on."""
        self._frames[view] = frame
        wake()

    def latest(self, view: str) -> Frame | None:
        """Return the newest."""
        return self._frames.get(view)


class Channel:
    """What a picture of a page shows: under `key`, which no other browser can guess, while this object lives."""

    def __init__(self, source: FrameSource, view: str) -> None:
        self.source, self.view = source, view
        self.key = secrets.token_urlsafe(12)
        _CHANNELS[self.key] = self

    def switch(self, view: str) -> None:
        """Show another view of the source."""
        self.view = view
        wake()

    def latest(self) -> Picture | None:
        """Return what is to be seen."""
        return self.source.latest(self.view)


class Wanted(msgspec.Struct, forbid_unknown_fields=True):
    """One view in a page's request."""

    have: int
    """Version of what it shows; 0: nothing."""
    cells: int
    """Range cells that it can draw."""


class Request(msgspec.Struct, forbid_unknown_fields=True):
    """What a page asks for."""

    views: dict[str, Wanted]
    """By the keys of their channels."""


def cells_of(level_db: Floats32, scale_db: tuple[float, float]) -> Cells:
    """Return levels (beams, samples), dB, as cells; what is no number as the lowest."""
    low, high = scale_db
    scaled = (level_db - np.float32(low)) * np.float32(255.0 / (high - low))
    np.fmax(scaled, np.float32(0.0), out=scaled)  # of a number and none: the number
    np.minimum(scaled, np.float32(255.0), out=scaled)
    scaled += np.float32(0.5)
    return scaled.astype(np.uint8)


def pooled(image: Cells, most: int) -> Cells:
    """Return the highest of each few neighbouring samples: `most` cells a row or fewer, and no echo is lost."""
    samples = image.shape[1]
    window = pool_of(samples, most)
    if window == 1:
        return image
    highest = image[:, ::window].copy()
    for k in range(1, window):  # far quicker than a maximum over a short axis
        later = image[:, k::window]
        np.maximum(highest[:, : later.shape[1]], later, out=highest[:, : later.shape[1]])
    return highest


def pool_of(samples: int, most: int) -> int:
    """Return how many samples become one cell."""
    return max(1, -(-samples // max(1, min(most, MOST_CELLS))))


def encode(views: Iterable[tuple[str, int, Picture]]) -> bytes:
    """Return the message with these views: key, range cells that the page can draw, frame."""
    headers: list[dict[str, Any]] = []
    payload: list[bytes] = []
    for key, most, frame in views:
        cells = pooled(frame.cells, most)
        headers.append({"key": key, **_header(frame, cells, pool_of(frame.cells.shape[1], most))})
        payload.append(cells.tobytes())
        if frame.attended is not None:
            payload.append(pooled(frame.attended.view(np.uint8), most).tobytes())
    header = msgspec.json.encode({"views": headers})
    return b"".join((len(header).to_bytes(4, "little"), header, *payload))


def _header(frame: Picture, cells: Cells, pool: int) -> dict[str, Any]:
    return {
        "version": frame.version,
        "beams": cells.shape[0],
        "cells": cells.shape[1],
        "pool": pool,
        "samples": frame.cells.shape[1],
        "attention": frame.attended is not None,
        **frame.header(),
    }


def wake() -> None:
    """Notify all waiting pages that something new may be shown. From any thread."""
    for waiter in list(_WAITERS):
        waiter.wake()


async def pull(websocket: WebSocket) -> None:
    """Answer one page's requests, the newest only, until it goes."""
    await websocket.accept()
    waiter = _Waiter()
    _WAITERS.add(waiter)
    answering = asyncio.create_task(_answer(websocket, waiter))
    try:
        while (message := await websocket.receive())["type"] == "websocket.receive":
            waiter.request = msgspec.json.decode(message.get("text") or "", type=Request)
            waiter.changed.set()
    except msgspec.MsgspecError:
        await websocket.close(NOT_UNDERSTOOD)
    finally:
        answering.cancel()
        _WAITERS.discard(waiter)


async def _answer(websocket: WebSocket, waiter: "_Waiter") -> None:
    with contextlib.suppress(WebSocketDisconnect):
        while True:
            await waiter.changed.wait()
            waiter.changed.clear()
            if views := list(_to_send(waiter.request)):
                waiter.request = Request({})
                await websocket.send_bytes(encode(views))


def _to_send(request: Request) -> Iterable[tuple[str, int, Picture]]:
    for key, wanted in request.views.items():
        channel = _CHANNELS.get(key)
        frame = channel.latest() if channel else None
        if frame is not None and frame.version != wanted.have:
            yield key, wanted.cells, frame


class _Waiter:
    """A page's open request."""

    def __init__(self) -> None:
        self.request = Request({})
        self.changed = asyncio.Event()
        self._loop = asyncio.get_running_loop()

    def wake(self) -> None:
        """Look again whether there is something to send. From any thread."""
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self.changed.set)


_CHANNELS: "WeakValueDictionary[str, Channel]" = WeakValueDictionary()
_WAITERS: "WeakSet[_Waiter]" = WeakSet()
