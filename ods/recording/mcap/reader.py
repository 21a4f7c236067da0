"""Reads recordings: one segment, or a folder of them, whole, torn, foreign or hostile, in bounded memory."""

import logging
import re
import struct
import zlib
from collections import Counter
from collections.abc import Collection, Iterator
from functools import cached_property
from pathlib import Path
from typing import BinaryIO, NamedTuple

import msgspec
from mcap.opcode import Opcode
from mcap.records import Attachment, Header, Metadata

from ods import __version__
from ods.base.files.in_file import opened
from ods.recording.errors import RecordingError, UnreadableError
from ods.recording.mcap.chunk import (
    BAD_CHUNK,
    BAD_RECORD,
    Channels,
    bounded_stream,
    log_time,
    stream,
    unpacked,
    unzipper,
)
from ods.recording.mcap.framing import ANY_MAGIC, MAGIC, MB, MESSAGE, PROFILE, Frame, frames
from ods.recording.mcap.topics import decoded

log = logging.getLogger(__name__)

SUFFIX = ".mcap"
MAP_COST = 15
"""Times as much memory as its bytes a map of very short texts takes."""
ODS = "ods"
"""Name of the metadata that every segment has; `utc_offset_ns` is among them."""
MOST_EXTRAS_BYTES = 48 * MB
"""Of all attachments and metadata of a recording: more are counted and left out."""
CONTENTS = frozenset({Opcode.CHANNEL, Opcode.CHUNK, Opcode.MESSAGE})
EXTRAS = frozenset({Opcode.METADATA, Opcode.ATTACHMENT})


class Recorded(NamedTuple):
    """One message of the bus."""

    topic: str
    log_ns: int
    """When the recorder received it, CLOCK_MONOTONIC of the recorded computer."""
    utc_ns: int
    """The same instant, UTC by the offset of the recording's start: a step of UTC does not show."""
    data: bytes
    """Msgpack, exactly as on the wire."""

    def message(self) -> msgspec.Struct:
        """Return it decoded, types and bounds checked. Raises ValueError, of which msgspec's errors are some."""
        return decoded(self.topic, self.data)


def open_recording(path: Path) -> "Recording":
    """Open a segment, a folder of segments, or one with a single such folder. Raises RecordingError."""
    try:
        folder = path.is_dir()
        paths = _segments_in(path) if folder else [path]
        losses: Counter[str] = Counter()
        segments = []
        versions = set()
        for each in paths:
            try:
                versions.add(_check_head(each))
            except UnreadableError:
                if not folder:
                    raise
                losses["unreadable_segments"] += 1
            else:
                segments.append(each)
    except OSError as error:
        raise UnreadableError(f"{path}: {error.strerror}") from error
    if not segments:
        raise UnreadableError(f"{path}: none of its {len(paths)} files *{SUFFIX} is a recording of ODS")
    if newer := sorted(filter(_is_newer, versions)):
        log.warning(
            "%s: recorded by ods %s: what this one, %s, does not know is left out", path, newer[-1], __version__
        )
    return Recording(segments, losses)


def _segments_in(folder: Path) -> list[Path]:
    """Raises RecordingError, OSError."""
    if here := sorted(folder.glob(f"*{SUFFIX}")):
        return here
    inner = sorted({path.parent for path in folder.glob(f"*/*{SUFFIX}")})
    if len(inner) > 1:
        names = ", ".join(path.name for path in inner[-5:])
        raise RecordingError(f"{folder}: contains {len(inner)} recordings, name one of them: {names}")
    if not inner:
        next(folder.iterdir(), None)  # an error where it may not be looked into: glob only finds nothing then
        raise UnreadableError(f"{folder}: no recording in it (no *{SUFFIX})")
    return sorted(inner[0].glob(f"*{SUFFIX}"))


class Recording:
    """Messages of a recording, in order of log time.

    `losses`, as far as it has been read: torn (segments cut off), overlong (records beyond all bounds), bad_chunks
    (wrong checksum, unknown compression, too large), bad_records, unknown_channels (messages of an undeclared
    channel, or of one that is not msgpack), unreadable_segments, segments_without_utc (without the metadata `ods`),
    left_out (metadata and attachments beyond all bounds).
    """

    def __init__(self, segments: list[Path], losses: "Counter[str]") -> None:
        """Take segments in their order, each seen to begin as one of ods."""
        self.segments = segments
        self.losses = losses

    @property
    def metadata(self) -> dict[str, dict[str, str]]:
        """By name; of equal names the first. `ods` is there in each segment: versions, CPU, offset of UTC."""
        return self._extras[0]

    @property
    def attachments(self) -> dict[str, bytes]:
        """By name; of equal names the first: `config.toml`, `map.sqlite` (the map at the start, if there was any)."""
        return self._extras[1]

    @cached_property
    def _extras(self) -> tuple[dict[str, dict[str, str]], dict[str, bytes]]:
        metadata: dict[str, dict[str, str]] = {}
        attachments: dict[str, bytes] = {}
        held = 0
        for path in self.segments:
            for frame in frames_of(path, EXTRAS, Counter()):
                held += len(frame.content) * (MAP_COST if frame.opcode == Opcode.METADATA else 1)
                if held > MOST_EXTRAS_BYTES:
                    self.losses["left_out"] += 1
                    return metadata, attachments
                try:
                    if frame.opcode == Opcode.METADATA:
                        extra = Metadata.read(bounded_stream(frame.content))
                        metadata.setdefault(extra.name, extra.metadata)
                    else:
                        enclosed = _attachment(frame.content)
                        attachments.setdefault(enclosed.name, enclosed.data)
                except BAD_RECORD:
                    self.losses["bad_records"] += 1
        return metadata, attachments

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Recorded]:
        """Yield the messages of some topics, by default of all, in order of log time. Raises UnreadableError.

        What several readers lose of one recording counts once.
        """
        lost: Counter[str] = Counter()
        for path in self.segments:
            segment = _Segment(topics, lost, _offset_ns(path, lost))
            for frame in frames_of(path, CONTENTS, lost):
                yield from segment.take(frame)
                if lost:
                    self.losses |= lost
            self.losses |= lost


def frames_of(
    path: Path, wanted: Collection[int], losses: "Counter[str]", heads: Collection[int] = ()
) -> Iterator[Frame]:
    """Yield the records of a segment, as `frames` does. Raises UnreadableError."""
    try:
        with opened(path) as file:
            file.seek(len(MAGIC))
            yield from frames(file, wanted, losses, heads)
    except OSError as error:
        raise UnreadableError(f"{path}: {error.strerror}") from error


def _offset_ns(path: Path, losses: "Counter[str]") -> int:
    """Return UTC less CLOCK_MONOTONIC of a segment. Other writers may put it behind all messages, or leave it out."""
    for frame in frames_of(path, {Opcode.METADATA}, Counter()):
        try:
            extra = Metadata.read(bounded_stream(frame.content))
            if extra.name == ODS:
                return int(extra.metadata["utc_offset_ns"])
        except (*BAD_RECORD, KeyError):
            losses["bad_records"] += 1
    losses["segments_without_utc"] += 1
    return 0


class _Segment:
    """State of one file while it is read."""

    def __init__(self, topics: Collection[str] | None, losses: "Counter[str]", offset_ns: int) -> None:
        self._topics = topics
        self._losses = losses
        self._offset_ns = offset_ns
        self._channels = Channels(losses)
        self._unzip = unzipper()

    def take(self, frame: Frame) -> Iterator[Recorded]:
        """Yield the messages in a record of CONTENTS."""
        if frame.opcode == Opcode.CHANNEL:
            self._channels.learn(frame.content)
        elif frame.opcode == Opcode.MESSAGE:
            yield from self._message(memoryview(frame.content))
        elif frame.opcode == Opcode.CHUNK:
            yield from self._chunk(frame.content)

    def _chunk(self, content: bytes) -> Iterator[Recorded]:
        try:
            records = unpacked(content, self._unzip)
        except BAD_CHUNK:
            self._losses["bad_chunks"] += 1
            return
        del content
        held = sorted((message for _, message in self._channels.messages(records)), key=log_time)
        for message in held:
            yield from self._message(message)

    def _message(self, content: memoryview) -> Iterator[Recorded]:
        if len(content) < MESSAGE.size:
            self._losses["bad_records"] += 1
            return
        channel, _, utc_ns, _ = MESSAGE.unpack_from(content)
        topic = self._channels.topics.get(channel)
        if topic is None:
            self._losses["unknown_channels"] += 1
        elif self._topics is None or topic in self._topics:
            yield Recorded(topic, utc_ns - self._offset_ns, utc_ns, bytes(content[MESSAGE.size :]))


def _attachment(content: bytes) -> Attachment:
    """Raises BAD_RECORD."""
    (checksum,) = struct.unpack_from("<I", content, len(content) - 4)
    if checksum and zlib.crc32(content[:-4]) != checksum:
        raise ValueError("wrong checksum")
    found: Attachment = Attachment.read(stream(content))
    return found


def _check_head(path: Path) -> str:
    """Return the version of ods that wrote a file. Raises UnreadableError for one that is no recording; OSError."""
    with opened(path) as file:
        mark = file.read(len(MAGIC))
        if not mark:
            raise UnreadableError(f"{path}: the file is empty")
        if mark != MAGIC and mark.startswith(ANY_MAGIC):
            raise UnreadableError(f"{path}: an MCAP file of another version than {MAGIC[len(ANY_MAGIC) : -2].decode()}")
        if mark != MAGIC:
            raise UnreadableError(f"{path}: not an MCAP file")
        header = _header(file)
        if header is None or header.profile != PROFILE:
            raise UnreadableError(f"{path}: an MCAP file, but not a recording of ODS")
        return header.library.removeprefix("ods ")


def _header(file: BinaryIO) -> Header | None:
    for frame in frames(file, {Opcode.HEADER}, Counter()):
        try:
            header: Header = Header.read(stream(frame.content))
        except BAD_RECORD:
            return None
        return header
    return None


def _is_newer(version: str) -> bool:
    """Return whether a version is newer than this one; one that cannot be read is not."""
    there, here = (re.match(r"(\d+)\.(\d+)", text) for text in (version, __version__))
    return there is not None and here is not None and tuple(map(int, there.groups())) > tuple(map(int, here.groups()))
