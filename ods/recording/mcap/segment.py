"""Writes one segment of a recording: an MCAP file that is whole to its last message whatever stops its writer.

Messages are appended as they come, as records of their own; `close_chunk` then puts a compressed chunk into the place
of those since the last one. A writer that is killed leaves the last ones as they are; `ods record --finish` completes
them for other readers.
Positions are passed to each write, so that no error leaves the file in a state of which the writer does not know.
"""

import fcntl
import json
import os
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import msgspec
import zstandard
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from ods import __version__
from ods.recording.mcap.framing import CHUNK, MAGIC, MESSAGE, PROFILE, RECORD, encoded
from ods.recording.mcap.topics import MESSAGES, stamp_of

LEVEL = 1
"""Of zstd: higher ones gain nothing on sonar images."""
PRIVATE = 0x80
"""First opcode that is not assigned."""
U64, U32 = 2**64 - 1, 2**32 - 1


class Logged(NamedTuple):
    """One message to write."""

    topic: str
    utc_ns: int
    """When it was received, by the recording's own UTC."""
    data: bytes


class Segment:
    """One file. Methods raise OSError and leave the file whole; what they were given is then not in it."""

    def __init__(self, path: Path, offset_ns: int, metadata: Mapping[str, Mapping[str, str]]) -> None:
        """Make the file, which must not exist. `offset_ns`: UTC less CLOCK_MONOTONIC, in all its times."""
        self.path = path
        self.size = 0
        """Bytes of the file up to what waits for its chunk."""
        self._offset_ns = offset_ns
        self._waiting: list[bytes] = []
        self._in_place = True
        """What waits is in the file."""
        self._index: dict[int, list[tuple[int, int]]] = {}
        self._inside = 0
        self._chunks: list[bytes] = []
        self._enclosed: list[bytes] = []
        self._metadata: list[bytes] = []
        self._counts: Counter[int] = Counter()
        self._first_ns, self._last_ns = U64, 0
        self._zip = zstandard.ZstdCompressor(level=LEVEL)
        self._schemas = [_schema(number, topic) for number, topic in enumerate(MESSAGES, 1)]
        self._channels = [Channel(number, topic, "msgpack", {}, number) for number, topic in enumerate(MESSAGES, 1)]
        self._numbers = {topic: number for number, topic in enumerate(MESSAGES, 1)}
        self._file = path.open("xb", buffering=0)
        with suppress(OSError):  # some file systems have none
            fcntl.flock(self.fd, fcntl.LOCK_EX | fcntl.LOCK_NB)  # who completes files leaves it alone
        try:
            self._append(MAGIC + encoded(Header(PROFILE, f"ods {__version__}")))
            for name, fields in metadata.items():
                self.add_metadata(name, fields)
            self._append(encoded(*self._schemas, *self._channels))
        except OSError:
            self._file.close()
            path.unlink(missing_ok=True)
            raise

    @property
    def fd(self) -> int:
        """For fdatasync."""
        return self._file.fileno()

    @property
    def waiting_bytes(self) -> int:
        """Of messages that are not in a chunk yet."""
        return self._inside

    def write(self, messages: Iterable[Logged]) -> None:
        """Append messages."""
        entries = [self._entry(message) for message in messages]
        if not self._in_place:
            self._restore()
        new = b"".join(record for _, _, record in entries)
        self._put(new, self.size + self._inside)
        for channel, utc_ns, record in entries:
            self._waiting.append(record)
            self._index.setdefault(channel, []).append((utc_ns, self._inside))
            self._inside += len(record)
            self._counts[channel] += 1
            self._first_ns, self._last_ns = min(self._first_ns, utc_ns), max(self._last_ns, utc_ns)

    def close_chunk(self) -> None:
        """Compress what has been written since the last chunk."""
        if not self._waiting:
            return
        records = b"".join(self._waiting)
        packed = self._zip.compress(records)
        times = [utc_ns for entries in self._index.values() for utc_ns, _ in entries]
        inside = CHUNK.pack(min(times), max(times), len(records), zlib.crc32(records), len(b"zstd")) + b"zstd"
        inside += len(packed).to_bytes(8, "little") + packed
        chunk = RECORD.pack(Opcode.CHUNK, len(inside)) + inside
        self._replace_waiting(chunk, len(records), len(packed), (min(times), max(times)))

    def add_metadata(self, name: str, fields: Mapping[str, str]) -> None:
        """Add metadata."""
        self.close_chunk()
        record = encoded(Metadata(name, dict(fields)))
        start = self._append(record)
        self._metadata.append(encoded(MetadataIndex(start, len(record), name)))

    def enclose(self, name: str, media_type: str, data: bytes, utc_ns: int) -> None:
        """Add a file."""
        self.close_chunk()
        record = encoded(Attachment(utc_ns, utc_ns, name, media_type, data))
        start = self._append(record)
        index = AttachmentIndex(start, len(record), utc_ns, utc_ns, len(data), name, media_type)
        self._enclosed.append(encoded(index))

    def finish(self) -> None:
        """Write the index, by which readers find their way without reading everything, and close the file."""
        try:
            self.close_chunk()
            self._append(self._summary())
        finally:
            self.close()

    def close(self) -> None:
        """Close the file as it is."""
        self._file.close()

    def _entry(self, message: Logged) -> tuple[int, int, bytes]:
        stamp = stamp_of(message.data)
        seq = stamp.seq if stamp and stamp.seq is not None else 0
        made_ns = message.utc_ns if stamp is None or stamp.t_ns is None else stamp.t_ns + self._offset_ns
        channel = self._numbers[message.topic]
        head = MESSAGE.pack(channel, seq & U32, message.utc_ns, min(max(made_ns, 0), U64))
        record = RECORD.pack(Opcode.MESSAGE, MESSAGE.size + len(message.data)) + head + message.data
        return channel, message.utc_ns, record

    def _restore(self) -> None:
        """Put the messages that wait for their chunk where the chunk was to be."""
        self._put(b"".join(self._waiting), self.size)
        self._in_place = True

    def _put(self, data: bytes, place: int) -> int:
        """Write at a place, and cut off what cannot be written whole; return the length."""
        left, position = memoryview(data), place
        try:
            while left:
                count = os.pwrite(self.fd, left, position)
                left, position = left[count:], position + count
        except OSError:
            os.ftruncate(self.fd, place)
            raise
        return len(data)

    def _append(self, data: bytes) -> int:
        """Write what is no message, with no message waiting; return its place."""
        place = self.size
        self.size += self._put(data, place)
        return place

    def _replace_waiting(self, chunk: bytes, size: int, packed: int, times: tuple[int, int]) -> None:
        place = self.size
        indexes, offsets = b"", {}
        for channel, entries in self._index.items():
            offsets[channel] = place + len(chunk) + len(indexes)
            indexes += encoded(MessageIndex(channel, entries))
        self._in_place = False
        try:
            self._put(chunk + indexes + _filler(self._inside - len(chunk) - len(indexes)), place)
        except OSError:
            with suppress(OSError):
                self._restore()
            raise
        self._in_place = True
        os.ftruncate(self.fd, place + len(chunk) + len(indexes))
        self.size = place + len(chunk) + len(indexes)
        self._chunks.append(
            encoded(
                ChunkIndex(
                    chunk_length=len(chunk),
                    chunk_start_offset=place,
                    compression="zstd",
                    compressed_size=packed,
                    message_end_time=times[1],
                    message_index_length=len(indexes),
                    message_index_offsets=offsets,
                    message_start_time=times[0],
                    uncompressed_size=size,
                )
            )
        )
        self._waiting, self._index, self._inside = [], {}, 0

    def _summary(self) -> bytes:
        """Return the end of the file; positions in it are counted from the file's start."""
        head = encoded(DataEnd(0))
        start = self.size + len(head)
        groups = {
            Opcode.SCHEMA: encoded(*self._schemas),
            Opcode.CHANNEL: encoded(*self._channels),
            Opcode.STATISTICS: encoded(self._statistics()),
            Opcode.CHUNK_INDEX: b"".join(self._chunks),
            Opcode.ATTACHMENT_INDEX: b"".join(self._enclosed),
            Opcode.METADATA_INDEX: b"".join(self._metadata),
        }
        summary, offsets = b"", b""
        for opcode, group in groups.items():
            offsets += encoded(SummaryOffset(opcode, start + len(summary), len(group)))
            summary += group
        footer = Footer(summary_start=start, summary_offset_start=start + len(summary), summary_crc=0)
        unchecked = encoded(footer)
        footer.summary_crc = zlib.crc32(summary + offsets + unchecked[:-4])
        return head + summary + offsets + encoded(footer) + MAGIC

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=len(self._enclosed),
            channel_count=len(self._channels),
            channel_message_counts=dict(self._counts),
            chunk_count=len(self._chunks),
            message_count=self._counts.total(),
            message_end_time=self._last_ns,
            message_start_time=self._first_ns if self._counts else 0,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )


def _filler(size: int) -> bytes:
    """Return the head of a record of `size` bytes that readers skip: what is left of the messages until it is cut off.

    A kill may come before that. Too few bytes for a record are counted as torn then, and nothing is lost by them.
    """
    return RECORD.pack(PRIVATE, size - RECORD.size) if size >= RECORD.size else b""


def _schema(number: int, topic: str) -> Schema:
    kind = MESSAGES[topic]
    return Schema(number, json.dumps(msgspec.json.schema(kind)).encode(), "jsonschema", kind.__name__)
