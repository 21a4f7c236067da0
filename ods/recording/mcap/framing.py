"""The outer layer of an MCAP file: records, each an opcode, a length and its content. Bounds for files that lie.

Source: the MCAP specification, version 0. Integers are little endian.
"""

import os
import struct
from collections import Counter
from collections.abc import Collection, Iterator
from typing import Any, BinaryIO, NamedTuple

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import McapRecord

MAGIC = b"\x89MCAP0\r\n"
ANY_MAGIC = b"\x89MCAP"
"""How files of all versions of the format begin."""
PROFILE = "ods"
RECORD = struct.Struct("<BQ")
"""Opcode, length of what follows."""
MESSAGE = struct.Struct("<HIQQ")
"""Channel, sequence, log time, publish time; then the message's bytes."""
CHUNK = struct.Struct("<QQQII")
"""Earliest and latest log time, size and CRC-32 of the records inside, length of the compression's name; then the name,
the compressed size as 8 bytes, and the compressed records."""

HEAD_BYTES = CHUNK.size
"""The longest head that a record's content has."""

MB = 1_000_000
LONGEST_MESSAGE_BYTES = 32 * MB
"""On the bus a message may be longer; no ping of a real sonar is. Bounds the reader's memory, too."""
LONGEST_RECORD_BYTES = LONGEST_MESSAGE_BYTES + 4 * MB
LONGEST_CHUNK_BYTES = LONGEST_MESSAGE_BYTES + 4 * MB
"""Of the records inside, uncompressed."""


class Frame(NamedTuple):
    """One record as it lies in the file."""

    opcode: int
    start: int
    """Where it begins, bytes from the start of the file."""
    content: bytes


def encoded(*records: McapRecord) -> bytes:
    """Return records as bytes of a file."""
    builder: Any = RecordBuilder()  # typed in part only
    for record in records:
        record.write(builder)
    content: bytes = builder.end()
    return content


def frames(
    file: BinaryIO, wanted: Collection[int], losses: "Counter[str]", heads: Collection[int] = ()
) -> Iterator[Frame]:
    """Yield the records of the wanted kinds up to the footer, or to the last whole one of a file that was cut off.

    `file` stands behind the magic, or behind any record. Of the kinds in `heads` the first HEAD_BYTES are read only.
    Counts what is lost: torn (what begins no record, or one that the file does not hold to its end: what follows is
    not read), overlong (records beyond LONGEST_RECORD_BYTES).
    """
    size = os.fstat(file.fileno()).st_size
    position = file.tell()
    while position < size:
        head = file.read(RECORD.size)
        if len(head) < RECORD.size:
            losses["torn"] += 1
            return
        opcode, length = RECORD.unpack(head)
        if opcode == 0 or length > size - position - RECORD.size:
            losses["torn"] += 1
            return
        if opcode not in wanted and opcode not in heads:
            file.seek(length, os.SEEK_CUR)
        elif length > LONGEST_RECORD_BYTES:
            losses["overlong"] += 1
            file.seek(length, os.SEEK_CUR)
        elif opcode in heads:
            yield Frame(opcode, position, file.read(min(length, HEAD_BYTES)))
            file.seek(position + RECORD.size + length)
        else:
            yield Frame(opcode, position, file.read(length))
        position += RECORD.size + length
        if opcode == Opcode.FOOTER:
            return
