"""Finds Norbit packets in a byte stream. Sans-IO: bytes go in, whole packets come out, every loss is counted.

A header is believed when its kind is known and its size possible; an image only when its counts and sizes fit each
other, which is known as soon as its first 192 bytes are there; and a whole packet when its checksum is right. Otherwise
the search goes on just behind the false preamble, so that a false header swallows little.
"""

import re
from collections import Counter, deque
from typing import NamedTuple

from ods.sonar_link.norbit import packets
from ods.sonar_link.norbit.packets import HEADER_BYTES, IMAGE_AT, PREAMBLE, Buffer, Header, PacketKind

KNOWN_KINDS = frozenset(PacketKind)
MAX_PACKET_BYTES = 4 * 1024 * 1024
"""The document's largest has 1,048,768."""
CHECKED_AGAIN = 8
"""A byte is checked so many times: headers within false packets, each with a checksum of all that follows, would
otherwise cost a megabyte's checksum each. What would cost more is no packet."""
KIND_BYTES = 4
_KNOWN_HEAD = re.compile(
    re.escape(PREAMBLE) + b"(?:%b)" % b"|".join(re.escape(kind.to_bytes(KIND_BYTES, "little")) for kind in PacketKind)
)
"""A preamble with a known kind: searched for at once, as a stream of preambles alone would cost much else."""


class Packet(NamedTuple):
    """One whole packet."""

    header: Header
    data: bytes
    """All of it, header included."""
    first_ns: int
    """When its first byte was read."""
    last_ns: int


def fault_of(data: Buffer, at: int = 0, max_bytes: int = MAX_PACKET_BYTES) -> str | None:
    """Say why the bytes from `at` on are no packet; '' when they are, or its beginning; None when too few tell."""
    there = len(data) - at
    if there < HEADER_BYTES:
        return None
    header = packets.unpack_header(data, at)
    if data[at : at + len(PREAMBLE)] != PREAMBLE or header.kind not in KNOWN_KINDS:
        return "unknown_message"
    if header.size > max_bytes:
        return "overlong_record"
    if header.size < (IMAGE_AT if header.kind == PacketKind.IMAGE else HEADER_BYTES):
        return "short_record"
    if header.kind != PacketKind.IMAGE:
        return ""
    if there < IMAGE_AT:
        return None
    return "" if packets.fits(packets.decode_image_head(data, at), header.size) else "bad_ping"


class Framer:
    """Turns chunks of a stream into packets, in any chunking the same unless most of it are false headers.

    Counters: records (whole packets); garbage_bytes (bytes of no packet); and one for each reason to disbelieve a
    header: unknown_message, overlong_record, short_record, bad_ping, bad_checksum, truncated_record, nested_record
    (without a checksum, the start of another packet of the kind in it tells that its own end was lost).
    """

    def __init__(self, max_packet_bytes: int = MAX_PACKET_BYTES, counters: "Counter[str] | None" = None) -> None:
        self.counters: Counter[str] = Counter() if counters is None else counters
        self._max_packet_bytes = max_packet_bytes
        self._bytes = bytearray()
        self._credit = max_packet_bytes  # bytes whose checksum may be computed
        self._start = 0  # position of the buffer's first byte in the stream
        self._arrivals: deque[tuple[int, int]] = deque()  # (position behind a chunk, when it was read)

    def feed(self, data: bytes | bytearray | memoryview, t_ns: int = 0) -> list[Packet]:
        """Take the next bytes of the stream, read at `t_ns`; return the packets that they complete."""
        if not len(data):
            return []
        self._bytes += data
        self._credit = min(self._credit + CHECKED_AGAIN * len(data), CHECKED_AGAIN * self._max_packet_bytes)
        self._arrivals.append((self._start + len(self._bytes), t_ns))
        return self._packets()

    @property
    def waiting_since_ns(self) -> int | None:
        """When the first byte of the packet under way was read; None when none is."""
        return self._arrivals[0][1] if self._bytes.startswith(PREAMBLE) else None

    @property
    def missing_bytes(self) -> int:
        """Bytes that must come before the packet under way can be complete; 0 when none is under way."""
        if self.waiting_since_ns is None or len(self._bytes) < HEADER_BYTES:
            return 0
        return packets.unpack_header(self._bytes).size - len(self._bytes)

    def give_up(self) -> list[Packet]:
        """Disbelieve the header of the packet under way; return the packets found behind it."""
        if self.waiting_since_ns is None:
            return []
        self.counters["truncated_record"] += 1
        self._discard(len(PREAMBLE))
        return self._packets()

    def flush(self) -> list[Packet]:
        """End the stream: give up whatever is under way; return the packets found in it. Feeding may go on."""
        found: list[Packet] = []
        while self.waiting_since_ns is not None:
            found += self.give_up()
        self._discard(len(self._bytes))
        return found

    def _packets(self) -> list[Packet]:
        found: list[Packet] = []
        while self._find_preamble():
            fault = fault_of(self._bytes, 0, self._max_packet_bytes)
            if fault is None:
                break
            header = packets.unpack_header(self._bytes)
            if not fault and len(self._bytes) < header.size:
                break
            fault = fault or self._fault_of_content(header)
            if fault:
                self.counters[fault] += 1
                self._discard(len(PREAMBLE))
            else:
                found.append(self._take(header))
        return found

    def _fault_of_content(self, header: Header) -> str:
        """Say why the whole packet cannot be one, '' when it can."""
        if header.checksum:
            self._credit -= header.size
            if self._credit < 0:
                self._credit += header.size
                return "bad_checksum"
            with memoryview(self._bytes) as whole:
                return "" if packets.is_sound(whole, header) else "bad_checksum"
        alike = self._bytes[: len(PREAMBLE) + KIND_BYTES]
        return "nested_record" if self._bytes.find(alike, 1, header.size) >= 0 else ""

    def _find_preamble(self) -> bool:
        """Drop what cannot begin a packet; tell whether a preamble comes first."""
        head = _KNOWN_HEAD.search(self._bytes)
        untold = max(0, len(self._bytes) - len(PREAMBLE) - KIND_BYTES + 1)  # behind it a kind is not there yet
        at = head.start() if head else self._bytes.find(PREAMBLE, untold)
        tail = next((n for n in (3, 2, 1) if self._bytes.endswith(PREAMBLE[:n])), 0)
        begin = at if at >= 0 else len(self._bytes) - tail
        if unknown := self._bytes.count(PREAMBLE, 0, begin):
            self.counters["unknown_message"] += unknown
        self._discard(begin)
        return at >= 0

    def _take(self, header: Header) -> Packet:
        last_ns = self._arrival_of(self._start + header.size - 1)
        with memoryview(self._bytes) as whole:
            data = bytes(whole[: header.size])
        packet = Packet(header, data, self._arrivals[0][1], last_ns)
        self.counters["records"] += 1
        self._drop(header.size)
        return packet

    def _arrival_of(self, position: int) -> int:
        return next(t_ns for end, t_ns in self._arrivals if position < end)

    def _discard(self, count: int) -> None:
        if count > 0:
            self.counters["garbage_bytes"] += count
            self._drop(count)

    def _drop(self, count: int) -> None:
        del self._bytes[:count]
        self._start += count
        while self._arrivals and self._arrivals[0][0] <= self._start:
            self._arrivals.popleft()
