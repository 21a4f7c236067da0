"""What of a byte stream are Norbit packets.

A header is believed when its kind is known and its size possible; an image only when its counts and sizes fit each
other, which is known as soon as its first 192 bytes are there; and a whole packet when its checksum is right.
"""

import re
from collections import Counter

from ods.sonar_link.norbit import packets
from ods.sonar_link.norbit.packets import HEADER_BYTES, IMAGE_AT, PREAMBLE, Buffer, Header, PacketKind
from ods.sonar_link.sync_framer import MAX_PACKET_BYTES, ChecksumBudget, Packet, SyncFramer

KNOWN_KINDS = frozenset(PacketKind)
KIND_BYTES = 4
_KNOWN_HEAD = re.compile(
    re.escape(PREAMBLE) + b"(?:%b)" % b"|".join(re.escape(kind.to_bytes(KIND_BYTES, "little")) for kind in PacketKind)
)


def fault_of(data: Buffer, at: int = 0, max_bytes: int = MAX_PACKET_BYTES) -> str | None:
    """Return why the bytes from `at` on are no packet; '' when they are, or its beginning; None when there are too
    few."""
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


class Framer(SyncFramer[Header]):
    """Finds Norbit packets; where most of a stream are false headers, fewer of them in small chunks than in large ones.

    Counts besides, of headers that are not believed: overlong_record, short_record, bad_ping, bad_checksum, and
    nested_record (without a checksum, the start of another packet of the kind in it shows that its own end was lost).
    """

    sync, known_head, head_bytes, header_bytes = PREAMBLE, _KNOWN_HEAD, len(PREAMBLE) + KIND_BYTES, HEADER_BYTES

    def __init__(self, max_packet_bytes: int = MAX_PACKET_BYTES, counters: "Counter[str] | None" = None) -> None:
        super().__init__(counters)
        self._max_packet_bytes = max_packet_bytes
        self._budget = ChecksumBudget(max_packet_bytes)

    def feed(self, data: bytes | bytearray | memoryview, t_ns: int = 0) -> list[Packet[Header]]:
        """Take the next bytes of the stream, read at `t_ns`; return the packets that they complete."""
        self._budget.earn(len(data))
        return super().feed(data, t_ns)

    def _header(self) -> Header:
        return packets.unpack_header(self._bytes)

    def _fault_of_head(self) -> str | None:
        return fault_of(self._bytes, 0, self._max_packet_bytes)

    def _fault_of_content(self, header: Header) -> str:
        if header.checksum:
            with memoryview(self._bytes) as whole:
                sound = self._budget.allows(header.size) and packets.is_sound(whole, header)
            return "" if sound else "bad_checksum"
        alike = self._bytes[: self.head_bytes]
        return "nested_record" if self._bytes.find(alike, 1, header.size) >= 0 else ""
