"""Index of a recording's messages, by the heads of its records: each can then be read by itself.

Behind each chunk its writer lists what lies in it; only a chunk without a complete list is opened.
So a segment that was cut off has the same index as a whole one, up to where it ends.
"""

import struct
import threading
from array import array
from collections import Counter, OrderedDict
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from mcap.opcode import Opcode

from ods.base.files.in_file import opened
from ods.recording.errors import RecordingError
from ods.recording.mcap.chunk import BAD_CHUNK, MOST_MESSAGES, Channels, log_time, unpacked, unzipper
from ods.recording.mcap.framing import CHUNK, LONGEST_RECORD_BYTES, MB, MESSAGE, RECORD, Frame
from ods.recording.mcap.reader import Recording, frames_of

MOST_PLACES = 8_000_000
"""Of a topic, 24 bytes each; more are counted as left_out."""
KEPT_BYTES = 4 * MB
"""Of the records in the last chunks that were opened: neighbours are asked for one after the other."""
LISTED = struct.Struct("<HI")
"""What an index of a chunk's messages begins with: channel, bytes of the entries."""
ENTRY = struct.Struct("<QQ")
"""Log time, place in the chunk's records."""
_WANTED = frozenset({Opcode.CHANNEL, Opcode.MESSAGE_INDEX})
_HEADS = frozenset({Opcode.CHUNK, Opcode.MESSAGE})
_BARE = -1
"""In the place of that in a chunk: the message lies in none."""


class Place(NamedTuple):
    """Where a message lies."""

    segment: int
    """Number in the recording's list."""
    start: int
    """Of the record in the file: the chunk, or the message itself."""
    inside: int
    """Of the message in the chunk's records; -1: it lies in no chunk."""


@dataclass(frozen=True, eq=False)
class Places:
    """Those of one topic's messages, in the order in which `Recording.messages` yields them."""

    _segments: "array[int]" = field(default_factory=lambda: array("Q"))
    _starts: "array[int]" = field(default_factory=lambda: array("Q"))
    _insides: "array[int]" = field(default_factory=lambda: array("q"))

    def __len__(self) -> int:
        return len(self._starts)

    def __getitem__(self, number: int) -> Place:
        """Return one. Raises IndexError."""
        return Place(self._segments[number], self._starts[number], self._insides[number])

    def add(self, segment: int, start: int, insides: list[int]) -> int:
        """Add those in one chunk, or one that lies in none; return for how many there was no room."""
        fitting = insides[: MOST_PLACES - len(self)]
        self._segments.extend([segment] * len(fitting))
        self._starts.extend([start] * len(fitting))
        self._insides.extend(fitting)
        return len(insides) - len(fitting)


def places_of(recording: Recording, topics: Collection[str]) -> dict[str, Places]:
    """Return where the messages of each of these topics lie. Raises RecordingError.

    Counts in the recording's losses what is lost, as far as it is seen; what a message holds is not looked at.
    """
    places = {topic: Places() for topic in topics}
    chunks = Chunks(recording.segments)
    for number, path in enumerate(recording.segments):
        scan = _Scan(number, places, chunks, recording.losses)
        for frame in frames_of(path, _WANTED, recording.losses, _HEADS):
            scan.take(frame)
        scan.end()
    return places


class _Scan:
    """State of one segment while its record headers are read."""

    def __init__(self, number: int, places: dict[str, Places], chunks: "Chunks", losses: "Counter[str]") -> None:
        self._number, self._places, self._chunks, self._losses = number, places, chunks, losses
        self._channels = Channels(losses)
        self._chunk: Frame | None = None
        self._listed: list[bytes] = []

    def take(self, frame: Frame) -> None:
        """Take a record, of chunks and messages the head."""
        if frame.opcode == Opcode.MESSAGE_INDEX:
            if self._chunk is not None and sum(map(len, self._listed)) < LONGEST_RECORD_BYTES:
                self._listed.append(frame.content)
            return
        self._end_chunk(self._listed)
        if frame.opcode == Opcode.CHANNEL:
            self._channels.learn(frame.content)
        elif frame.opcode == Opcode.CHUNK:
            self._chunk = frame
        elif len(frame.content) >= MESSAGE.size:
            channel, *_ = MESSAGE.unpack_from(frame.content)
            self._add(channel, frame.start, [_BARE])

    def end(self) -> None:
        """Take the last chunk: its index may be truncated."""
        self._end_chunk([])

    def _end_chunk(self, listed: list[bytes]) -> None:
        chunk = self._chunk
        self._chunk, self._listed = None, []
        if chunk is None:
            return
        try:
            places = dict(_entries(content, _most_in(chunk)) for content in listed)
        except (struct.error, ValueError):
            places = {}
        if not places or not places.keys() <= self._channels.topics.keys():
            places = self._opened(chunk.start)
        for channel, insides in places.items():
            self._add(channel, chunk.start, insides)

    def _opened(self, start: int) -> dict[int, list[int]]:
        """Return what lies in a chunk, by its channels."""
        try:
            records = self._chunks.records(self._number, start)
        except RecordingError:
            self._losses["bad_chunks"] += 1
            return {}
        places: dict[int, list[int]] = {}
        for inside, message in sorted(self._channels.messages(records), key=lambda found: log_time(found[1])):
            channel, *_ = MESSAGE.unpack_from(message)
            places.setdefault(channel, []).append(inside)
        return places

    def _add(self, channel: int, start: int, insides: list[int]) -> None:
        topic = self._channels.topics.get(channel)
        if topic is None:
            self._losses["unknown_channels"] += len(insides)
        elif topic in self._places and (left_out := self._places[topic].add(self._number, start, insides)):
            self._losses["left_out"] += left_out


def _entries(content: bytes, most: int) -> tuple[int, list[int]]:
    """Return a channel and the places of its messages in a chunk, in order of time. Raises struct.error, ValueError."""
    channel, length = LISTED.unpack_from(content)
    if length != len(content) - LISTED.size or length > most * ENTRY.size:
        raise ValueError("the length differs from the stated one, or there are more messages than fit into the chunk")
    entries = sorted(ENTRY.iter_unpack(content[LISTED.size :]), key=lambda entry: entry[0])
    return channel, [min(inside, 2**62) for _, inside in entries]


def _most_in(chunk: Frame) -> int:
    """Return how many messages a chunk may hold, by its header. Raises struct.error."""
    _, _, size, *_ = CHUNK.unpack_from(chunk.content)
    return min(int(size) // (RECORD.size + MESSAGE.size), MOST_MESSAGES)


class Chunks:
    """Reads messages by their places; the last chunks are kept. May be used from several threads."""

    def __init__(self, segments: list[Path]) -> None:
        self._segments = segments
        self._unzip = unzipper()
        self._kept: OrderedDict[tuple[int, int], bytes] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    def message(self, place: Place) -> bytes:
        """Return what a message holds. Raises RecordingError: there is none, or its chunk is bad."""
        if place.inside == _BARE:
            content = self._content(place.segment, place.start, Opcode.MESSAGE)
        else:
            content = self._inside(self.records(place.segment, place.start), place)
        return content[MESSAGE.size :]

    def records(self, segment: int, start: int) -> bytes:
        """Return the records in a chunk. Raises RecordingError."""
        with self._lock:
            key = segment, start
            if key not in self._kept:
                self._keep(key, self._unpacked(segment, start))
            self._kept.move_to_end(key)
            return self._kept[key]

    def _keep(self, key: tuple[int, int], records: bytes) -> None:
        self._kept[key] = records
        self._bytes += len(records)
        while self._bytes > KEPT_BYTES and len(self._kept) > 1:
            self._bytes -= len(self._kept.popitem(last=False)[1])

    def _unpacked(self, segment: int, start: int) -> bytes:
        content = self._content(segment, start, Opcode.CHUNK)
        try:
            return unpacked(content, self._unzip)
        except BAD_CHUNK as error:
            raise RecordingError(f"{self._segments[segment]}: bad chunk at byte {start}") from error

    def _content(self, segment: int, start: int, opcode: int) -> bytes:
        """Return the contents of a record of the file."""
        path = self._segments[segment]
        try:
            with opened(path) as file:
                file.seek(start)
                head = file.read(RECORD.size)
                found, length = RECORD.unpack(head) if len(head) == RECORD.size else (0, 0)
                content = file.read(length) if found == opcode and length <= LONGEST_RECORD_BYTES else b""
        except OSError as error:
            raise RecordingError(f"{path}: {error.strerror}") from error
        if found != opcode or len(content) < length:
            raise RecordingError(f"{path}: changed at byte {start} since it was opened")
        return content

    def _inside(self, records: bytes, place: Place) -> bytes:
        try:
            opcode, length = RECORD.unpack_from(records, place.inside)
        except struct.error:
            opcode, length = 0, 0
        start = place.inside + RECORD.size
        if opcode != Opcode.MESSAGE or length > len(records) - start:
            path = self._segments[place.segment]
            raise RecordingError(
                f"{path}: the index points to a message that is not there, in the chunk at byte {place.start}"
            )
        return records[start : start + length]
