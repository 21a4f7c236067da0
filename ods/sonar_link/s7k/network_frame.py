"""The network frame of the RESON 7k Data Format, in which records travel over TCP. Sans-IO: bytes in, bytes out.

A record is sent as one transmission of one or more packets, each behind a 36-byte header. Only what is surely such a
header is taken out of the stream; everything else is handed on, so that the record framer, which has a sync word and a
checksum, is the one judge of what is a record. A header that lies of its packet's size spoils no more than the record
that it cuts: a packet ends, whatever its header said, where a record's first packet begins within it.

Source: the 7k Data Format Definition's network frame as MB-System's 7k center client and the University of New
Hampshire's 7P client implement it; they agree on every field.
"""

import struct
from collections import Counter
from typing import NamedTuple

from ods.sonar_link.s7k.framer import FRAME_START

PACKET_VERSION = 5
MAX_PACKET_BYTES = 60_000
"""Longest packet that we send, header included."""

_HEADER = struct.Struct("<HHIHHIIIIHHI")
PACKET_HEADER_BYTES = _HEADER.size
HEADER_START = PACKET_VERSION.to_bytes(2, "little") + PACKET_HEADER_BYTES.to_bytes(2, "little")
RECORD_STARTED_BYTES = PACKET_HEADER_BYTES + len(FRAME_START)
"""A packet's header and behind it the start of a record: no samples look like that."""


class PacketHeader(NamedTuple):
    """The fields of a packet's header, in their order."""

    version: int
    offset: int
    """From the packet's start to its data."""
    total_packets: int
    """Packets of this transmission."""
    total_records: int
    transmission: int
    """The same in all packets of a transmission."""
    packet_size: int
    """Of this packet, header included."""
    total_size: int
    """Of the data of all packets of this transmission."""
    sequence: int
    """Of this packet within the transmission, from 0."""
    destination_device: int = 0
    """0: unspecified."""
    destination_enumerator: int = 0
    source_enumerator: int = 0
    source_device: int = 0


def frame_record(record: bytes, transmission: int, max_packet_bytes: int = MAX_PACKET_BYTES) -> bytes:
    """Return the packets that carry one record, from and to unspecified devices."""
    step = max_packet_bytes - PACKET_HEADER_BYTES
    parts = [record[at : at + step] for at in range(0, len(record), step)]
    packets = []
    for sequence, part in enumerate(parts):
        header = PacketHeader(
            version=PACKET_VERSION, offset=PACKET_HEADER_BYTES, total_packets=len(parts), total_records=1,
            transmission=transmission % 2**16, packet_size=PACKET_HEADER_BYTES + len(part), total_size=len(record),
            sequence=sequence,
        )  # fmt: skip
        packets.append(_HEADER.pack(*header) + part)
    return b"".join(packets)


class Deframer:
    """Takes the headers out of a stream, in any chunking the same.

    Counters: network_frames; unframed_bytes (bytes between packets, handed on like all others); lying_frames (packets
    with another one within, whose header is handed on, too).
    """

    def __init__(self, max_record_bytes: int, counters: "Counter[str] | None" = None) -> None:
        self.counters: Counter[str] = Counter() if counters is None else counters
        self._max_record_bytes = max_record_bytes
        self._data_left = 0
        self._data_end = b""  # of the packet, as far as it has been handed on: another one may begin there
        self._held = b""  # the beginning of what may be a header

    def feed(self, data: bytes) -> bytes:
        """Take the next bytes of the stream; return what they bring of records."""
        stream, at, out = self._held + data, 0, bytearray()
        while at < len(stream):
            if self._data_left:
                end = min(at + self._data_left, len(stream))
                end = at + self._handed_on(stream[at:end])
            else:
                end = _next_header(stream, at)
                if end == at:
                    if len(stream) - at < PACKET_HEADER_BYTES:
                        break
                    header = PacketHeader(*_HEADER.unpack_from(stream, at))
                    if self._believable(header):
                        self.counters["network_frames"] += 1
                        self._data_left = header.packet_size - PACKET_HEADER_BYTES
                        self._data_end = b""
                        at += PACKET_HEADER_BYTES
                        continue
                    end = at + 1
                self.counters["unframed_bytes"] += end - at
            out += stream[at:end]
            at = end
        self._held = stream[at:]
        return bytes(out)

    def flush(self) -> bytes:
        """End the stream; return what was held back. Feeding may go on with another stream."""
        held, self._held, self._data_left = self._held, b"", 0
        self.counters["unframed_bytes"] += len(held)
        return held

    def _handed_on(self, data: bytes) -> int:
        """Return how many of a packet's next bytes of data go on, which are all unless another packet begins there."""
        seen = self._data_end + data
        at = seen.find(HEADER_START)
        while 0 <= at <= len(seen) - RECORD_STARTED_BYTES:
            header = PacketHeader(*_HEADER.unpack_from(seen, at))
            starts = header.sequence == 0 and seen.startswith(FRAME_START, at + PACKET_HEADER_BYTES)
            if starts and self._believable(header):
                self.counters["lying_frames"] += 1
                before, self._data_end = len(self._data_end), b""
                self._data_left = max(0, header.packet_size - RECORD_STARTED_BYTES)
                return at + RECORD_STARTED_BYTES - before
            at = seen.find(HEADER_START, at + 1)
        self._data_end = seen[1 - RECORD_STARTED_BYTES :]
        self._data_left -= len(data)
        return len(data)

    def _believable(self, header: PacketHeader) -> bool:
        data_bytes = header.packet_size - PACKET_HEADER_BYTES
        return (
            0 < data_bytes <= header.total_size <= self._max_record_bytes
            and header.sequence < header.total_packets <= header.total_size
        )


def _next_header(stream: bytes, at: int) -> int:
    """Return where, from `at` on, a header may begin, perhaps with its start only; the end of the stream if nowhere."""
    found = stream.find(HEADER_START, at)
    if found >= 0:
        return found
    for length in range(min(len(HEADER_START) - 1, len(stream) - at), 0, -1):
        if stream.endswith(HEADER_START[:length]):
            return len(stream) - length
    return len(stream)
