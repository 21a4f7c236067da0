"""Contents of a segment's chunks: compressed records, most of them messages. Bounds for chunks that lie."""

import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from io import BytesIO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel

from ods.recording.mcap.framing import CHUNK, LONGEST_CHUNK_BYTES, MESSAGE, RECORD

BAD_RECORD = (McapError, struct.error, ValueError)
"""What decoding a record's content may raise."""
BAD_CHUNK = (*BAD_RECORD, zstandard.ZstdError, MemoryError)

LONGEST_TOPIC = 256
"""Characters of a channel's name: a chunk of 3 kB unpacks to one of 30 MB, and all are kept while a file is read."""
LONGEST_INDEX_RECORD = 1 << 20
"""Bytes of a record of metadata or of a channel: a map of very short texts takes some fifteen times as much."""
MOST_CHANNELS = 1000
"""Of a segment; the recorder writes as many as there are topics."""
MOST_MESSAGES = 200_000
"""In a chunk: each takes a few hundred bytes while they are put in order. The recorder's chunks are of about 1 MB."""


def stream(content: bytes) -> ReadDataStream:
    """Return a record's content as the library reads it."""
    return ReadDataStream(BytesIO(content))


def bounded_stream(content: bytes) -> ReadDataStream:
    """Return a record's content of which a map is made. Raises ValueError where that would be large."""
    if len(content) > LONGEST_INDEX_RECORD:
        raise ValueError(f"longer than {LONGEST_INDEX_RECORD} bytes")
    return stream(content)


class Channels:
    """The topics of a segment's channels, by their numbers. Counts bad_records in `losses`."""

    def __init__(self, losses: "Counter[str]") -> None:
        self.topics: dict[int, str] = {}
        self._losses = losses

    def learn(self, content: bytes) -> None:
        """Take a channel's record; of others than msgpack nothing is kept."""
        try:
            channel = Channel.read(bounded_stream(content))
        except BAD_RECORD:
            self._losses["bad_records"] += 1
            return
        if len(channel.topic) > LONGEST_TOPIC or len(self.topics) >= MOST_CHANNELS:
            self._losses["bad_records"] += 1
        elif channel.message_encoding == "msgpack":
            self.topics[channel.id] = channel.topic

    def messages(self, records: bytes) -> Iterator[tuple[int, memoryview]]:
        """Yield the messages in a chunk, where their records begin and their content; learn its channels."""
        whole, start, left = memoryview(records), 0, MOST_MESSAGES
        while start + RECORD.size <= len(whole):
            opcode, length = RECORD.unpack_from(whole, start)
            inside = start + RECORD.size
            if length > len(whole) - inside or not left:
                break
            if opcode == Opcode.MESSAGE and length >= MESSAGE.size:
                left -= 1
                yield start, whole[inside : inside + length]
            elif opcode == Opcode.CHANNEL:
                self.learn(bytes(whole[inside : inside + length]))
            start = inside + length
        if start != len(whole):
            self._losses["bad_records"] += 1


def log_time(message: memoryview) -> int:
    """Return when a message was received, UTC ns; of its record's content."""
    _, _, utc_ns, _ = MESSAGE.unpack_from(message)
    return int(utc_ns)


def unzipper() -> zstandard.ZstdDecompressor:
    """Return what `unpacked` needs; one at a time may use it."""
    return zstandard.ZstdDecompressor(max_window_size=LONGEST_CHUNK_BYTES)


def unpacked(content: bytes, unzip: zstandard.ZstdDecompressor) -> bytes:
    """Return the records in a chunk. Raises BAD_CHUNK."""
    _, _, size, checksum, name_length = CHUNK.unpack_from(content)
    if name_length > len(content) or size > LONGEST_CHUNK_BYTES:
        raise ValueError("too large")
    name = content[CHUNK.size : CHUNK.size + name_length]
    start = CHUNK.size + name_length
    (length,) = struct.unpack_from("<Q", content, start)
    packed = memoryview(content)[start + 8 : start + 8 + length]
    if name == b"zstd":
        stated = zstandard.frame_content_size(packed)
        if stated not in (-1, size):  # a bomb says itself how much it would take
            raise ValueError("the sizes inside and outside differ")
        records = unzip.decompress(packed, max_output_size=size)
    elif name == b"":
        records = bytes(packed)
    else:
        raise ValueError("unknown compression")
    if checksum and zlib.crc32(records) != checksum:
        raise ValueError("wrong checksum")
    return records
