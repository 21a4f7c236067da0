"""Logs of Oculus ViewPoint 1 (.oculus): a head, then items with a head and a time each; those of the sonar hold one
message of its network stream.

Source of the layout: struct RmLogHeader, RmLogItem and RecordTypes of Blueprint Subsea's SDK, as the public driver
ENSTABretagneRobotics/oculus_driver (Recorder.h) names their fields. Little endian, aligned as C does.
"""

import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from mmap import mmap
from pathlib import Path
from typing import NamedTuple

from ods.messages import Ping
from ods.sonar_link.files.decoder import Decoder
from ods.sonar_link.files.mapped_file import memory_map
from ods.sonar_link.files.ping_sequence import LazyPings, PingFileError, PingSequence
from ods.sonar_link.files.viewpoint.message import check, is_ping, ping_of
from ods.sonar_link.sync_framer import MAX_PACKET_BYTES

FILE_MARK, ITEM_MARK = (0x11223344).to_bytes(4, "little"), (0xAABBCCDD).to_bytes(4, "little")
FILE_HEAD = struct.Struct("<4sI16sHH4xqd")
"""Mark, bytes of this head, who wrote it, version, encryption, key, time."""
ITEM_HEAD = struct.Struct("<4sIHH4xdH2xII4x")
"""Mark, bytes of this head, type, version, time, compression, bytes unpacked, bytes that follow."""
SONAR = 10
"""Type of an item with a message of the sonar."""
PLAIN, PACKED = 0, 1
"""Compressions; packed is Qt's qCompress: the size, 4 bytes, big endian, and a stream of zlib."""
QT_SIZE_BYTES = 4


class _Item(NamedTuple):
    start: int
    """Of what follows its head."""
    size: int
    kind: int
    compression: int
    time_s: float


class OculusLogDecoder(Decoder):
    """Counts `other_messages` (items of other kinds, too), `corrupt_pings` and `garbage_bytes`.

    A ping's time is that of its item: when ViewPoint took it, UTC.
    """

    name = "Oculus .oculus"
    signature = ((0, FILE_MARK),)
    suffix = ".oculus"

    def read(self, path: Path) -> PingSequence:
        """Read a log. Raises PingFileError."""
        data = memory_map(path)
        if len(data) < FILE_HEAD.size or data[: len(FILE_MARK)] != FILE_MARK:
            raise PingFileError(f"{path}: not an Oculus ViewPoint log")
        _, head_bytes, _, _, encryption, _, _ = FILE_HEAD.unpack_from(data)
        if encryption:
            raise PingFileError(f"{path}: it is encrypted")
        losses: Counter[str] = Counter()
        found = [item for item in _items(data, max(head_bytes, FILE_HEAD.size), losses) if _is_ping(data, item, losses)]
        if not found:
            raise PingFileError(f"{path}: no complete simple ping result in it")
        return PingSequence(LazyPings(len(found), lambda index: _ping(data, found[index], index)), losses=losses)


def _items(data: mmap, start: int, losses: Counter[str]) -> Iterator[_Item]:
    """Yield each whole item; what is between them is counted."""
    while start < len(data):
        head = _head_at(data, start)
        if head is None:
            following = data.find(ITEM_MARK, start + 1)
            following = following if following >= 0 else len(data)
            losses["garbage_bytes"] += following - start
            start = following
        else:
            yield head
            start = head.start + head.size


def _head_at(data: mmap, start: int) -> _Item | None:
    """Return the item that begins at a place; None where none does that the file holds whole."""
    if data[start : start + len(ITEM_MARK)] != ITEM_MARK or start + ITEM_HEAD.size > len(data):
        return None
    _, head_bytes, kind, _, time_s, compression, _, size = ITEM_HEAD.unpack_from(data, start)
    inside = start + head_bytes
    whole = head_bytes >= ITEM_HEAD.size and inside + size <= len(data)
    return _Item(inside, size, kind, compression, time_s) if whole else None


def _is_ping(data: mmap, item: _Item, losses: Counter[str]) -> bool:
    if item.kind != SONAR:
        losses["other_messages"] += 1
        return False
    try:
        if not is_ping(_message(data, item)):
            losses["other_messages"] += 1
            return False
        _ping(data, item, 0)
    except (ValueError, struct.error, zlib.error):
        losses["corrupt_pings"] += 1
        return False
    return True


def _message(data: mmap, item: _Item) -> bytes:
    """Return the message in an item of the sonar. Raises ValueError, zlib.error where there is none."""
    if item.size > MAX_PACKET_BYTES or item.compression not in (PLAIN, PACKED):
        raise ValueError("too long for a message, or of unknown compression")
    content = data[item.start : item.start + item.size]
    if item.compression == PACKED:
        unzip = zlib.decompressobj()
        content = unzip.decompress(content[QT_SIZE_BYTES:], MAX_PACKET_BYTES)
        if not unzip.eof:
            raise ValueError("unpacks to more than a message can hold, or is truncated")
    check(content)
    return content


def _ping(data: mmap, item: _Item, index: int) -> Ping:
    """Decode the message of an item. Raises ValueError when its numbers do not fit each other."""
    return ping_of(_message(data, item), item.time_s, index)
