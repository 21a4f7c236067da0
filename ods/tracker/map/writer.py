"""The process that reads and writes the map file: the only one on board that waits for the disk.

The tracker starts it and talks to it over its standard input (`link`). A disk that stalls holds this process up and no
other, not even the tracker's end; a thread that waits for a disk would keep a killed tracker, and its lock, until the
disk is back. It ends when the tracker has gone and all that came is written, and takes no SIGTERM and no SIGINT.
"""

import select
import signal
import socket
import sys
from pathlib import Path
from typing import NamedTuple

from ods.runtime.port.backoff import Backoff
from ods.runtime.run_dir import Lock, RunDirError, is_locked
from ods.tracker.map.link import (
    FIRST_DELAY_S,
    LONGEST_DELAY_S,
    OBJECTS_A_PACKET,
    Change,
    Failed,
    Known,
    Link,
    LinkEndedError,
    Message,
    Written,
)
from ods.tracker.map.map_object import MapObject
from ods.tracker.map.store import MapError, MapStore, open_map

LOCK = "map"
"""One writer at a time: a tracker that was killed may have left one that still waits for the disk."""


class _Opened(NamedTuple):
    store: MapStore
    objects: list[MapObject]
    first_id: int


def serve(path: Path, origin_deg: tuple[float, float], run_dir: Path) -> None:
    """Serve the tracker at standard input until it has gone."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, signal.SIG_IGN)
    link = Link(socket.socket(fileno=sys.stdin.fileno()))
    opened = _opened(link, path, origin_deg, run_dir)
    if opened is None:
        return
    *full, last = [
        opened.objects[i : i + OBJECTS_A_PACKET] for i in range(0, len(opened.objects) + 1, OBJECTS_A_PACKET)
    ]
    for objects in full:
        _tell(link, Known(objects))
    _tell(link, Known(last, opened.first_id))
    try:
        _write(link, opened.store)
    finally:
        opened.store.close()


def _opened(link: Link, path: Path, origin_deg: tuple[float, float], run_dir: Path) -> _Opened | None:
    """Open and read the map, however long that takes; None: it could not be done, and the tracker has gone."""
    backoff, lock = Backoff(FIRST_DELAY_S, LONGEST_DELAY_S), None
    while True:
        try:
            lock = lock or Lock(run_dir, LOCK)
            return _read(path, origin_deg)
        except (MapError, RunDirError) as error:
            held = lock is None and is_locked(run_dir, LOCK)
            reason = f"map {path}: an earlier process is still writing it" if held else str(error)
            if not _tell(link, Failed(reason, opened=False)) or _has_gone(link, backoff.failed()):
                return None


def _read(path: Path, origin_deg: tuple[float, float]) -> _Opened:
    """Raises MapError."""
    store = open_map(path, *origin_deg)
    try:
        return _Opened(store, store.load(), store.first_free_id())
    except MapError:
        store.close()
        raise


def _write(link: Link, store: MapStore) -> None:
    """Make the changes that come until the tracker has gone, and those that it left."""
    while True:
        try:
            message = link.receive()
        except LinkEndedError:
            return
        if isinstance(message, Change):
            try:
                store.change(message.put, message.remove, message.next_id)
            except MapError as error:
                _tell(link, Failed(str(error), opened=True))
            else:
                _tell(link, Written())


def _tell(link: Link, message: Message) -> bool:
    """Return whether there was a tracker to receive it."""
    try:
        return link.send(message)
    except LinkEndedError:
        return False


def _has_gone(link: Link, within_s: float) -> bool:
    """Wait for this time; return early, with true, when the tracker has ended."""
    poller = select.poll()
    poller.register(link.fileno(), select.POLLRDHUP)
    return bool(poller.poll(1e3 * within_s))


if __name__ == "__main__":
    file, latitude_deg, longitude_deg, folder = sys.argv[1:]
    serve(Path(file), (float(latitude_deg), float(longitude_deg)), Path(folder))
