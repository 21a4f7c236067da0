"""Messages of the ping protocol in a stream of bytes.

A header is believed when its kind is one that a Ping360 sends and its size possible for that kind, and a whole message
when its checksum is right: a sum of 16 bits, so that the header's own checks count.
"""

import re
from collections import Counter

from ods.sonar_link.ping360 import messages
from ods.sonar_link.ping360.messages import FROM_SONAR, HEADER_BYTES, LEAST_BYTES, MOST_BYTES, START, Header, Kind
from ods.sonar_link.sync_framer import ChecksumBudget, Packet, SyncFramer

HEAD_BYTES = 6
"""From the start to the kind, both included."""
_KINDS = b"|".join(re.escape(kind.to_bytes(2, "little")) for kind in FROM_SONAR)
_KNOWN_HEAD = re.compile(re.escape(START) + b"..(?:" + _KINDS + b")", re.DOTALL)
MOST_OF_OTHERS = 512
"""Bytes of a payload without samples."""


class Framer(SyncFramer[Header]):
    """Finds messages. Counts besides, of headers that are not believed: overlong_record, short_record, bad_checksum."""

    sync, known_head, head_bytes, header_bytes = START, _KNOWN_HEAD, HEAD_BYTES, HEADER_BYTES

    def __init__(self, counters: "Counter[str] | None" = None) -> None:
        super().__init__(counters)
        self._budget = ChecksumBudget(MOST_BYTES)

    def feed(self, data: bytes | bytearray | memoryview, t_ns: int = 0) -> list[Packet[Header]]:
        """Take the next bytes of the stream, read at `t_ns`; return the messages that they complete."""
        self._budget.earn(len(data))
        return super().feed(data, t_ns)

    def _header(self) -> Header:
        return messages.unpack_header(self._bytes)

    def _fault_of_head(self) -> str | None:
        if len(self._bytes) < HEADER_BYTES:
            return None
        header = self._header()
        if header.kind not in LEAST_BYTES:
            return "unknown_message"
        has_samples = header.kind in (Kind.DEVICE_DATA, Kind.AUTO_DEVICE_DATA)
        if header.payload > (MOST_BYTES if has_samples else MOST_OF_OTHERS):
            return "overlong_record"
        return "short_record" if header.payload < LEAST_BYTES[Kind(header.kind)] else ""

    def _fault_of_content(self, header: Header) -> str:
        with memoryview(self._bytes) as whole:
            message = whole[: header.size]
            sound = self._budget.allows(header.size) and messages.is_sound(message)
            message.release()
        return "" if sound else "bad_checksum"
