"""What of a byte stream are Oculus messages.

They have no checksum. A header is believed when its kind is known and its size possible; a simple ping result
only when all its sizes and counts fit each other, which is known as soon as its first 122 or 202 bytes are there, and
when no other one begins in it.
"""

import re
from collections import Counter

from ods.sonar_link.oculus import messages
from ods.sonar_link.oculus.messages import CHECK_WORD, HEADER_BYTES, Buffer, Header, MessageKind
from ods.sonar_link.sync_framer import MAX_PACKET_BYTES, SyncFramer

KNOWN_KINDS = frozenset(MessageKind)
MAX_OTHER_BYTES = 65536
"""Longest message without an image."""
WITH_IMAGE = (MessageKind.PING, MessageKind.FULL_PING)
KIND_AT, KIND_BYTES = 6, 2
_KNOWN_HEAD = re.compile(
    CHECK_WORD + b".{%d}" % (KIND_AT - len(CHECK_WORD))
    + b"(?:%b)" % b"|".join(re.escape(kind.to_bytes(KIND_BYTES, "little")) for kind in sorted(KNOWN_KINDS)),
    re.DOTALL,
)  # fmt: skip
ALIKE_BYTES = 10
"""Of the header: sync word, source, destination, kind and version, the same in all results of one sonar."""


def fault_of(data: Buffer, at: int = 0, max_bytes: int = MAX_PACKET_BYTES) -> str | None:
    """Return why the bytes from `at` on are no message; '' when they are, or its beginning; None when there are too
    few."""
    there = len(data) - at
    if there < HEADER_BYTES:
        return None
    header = messages.unpack_header(data, at)
    if data[at : at + len(CHECK_WORD)] != CHECK_WORD or header.kind not in KNOWN_KINDS:
        return "unknown_message"
    if header.size > (max_bytes if header.kind in WITH_IMAGE else MAX_OTHER_BYTES):
        return "overlong_record"
    if header.kind != MessageKind.PING:
        return ""
    fixed = messages.result_bytes(header.version)
    if header.size < fixed:
        return "short_record"
    if there < fixed:
        return None
    return "" if messages.fits(messages.decode_ping_result(data, at), header.size) else "bad_ping"


class Framer(SyncFramer[Header]):
    """Finds Oculus messages.

    Counts besides, of headers that are not believed: overlong_record, short_record, bad_ping, nested_record (the start
    of another message of the kind lies in it: its own end was lost).
    """

    sync, known_head, head_bytes, header_bytes = CHECK_WORD, _KNOWN_HEAD, KIND_AT + KIND_BYTES, HEADER_BYTES

    def __init__(self, max_message_bytes: int = MAX_PACKET_BYTES, counters: "Counter[str] | None" = None) -> None:
        super().__init__(counters)
        self._max_message_bytes = max_message_bytes

    def _header(self) -> Header:
        return messages.unpack_header(self._bytes)

    def _fault_of_head(self) -> str | None:
        return fault_of(self._bytes, 0, self._max_message_bytes)

    def _fault_of_content(self, header: Header) -> str:
        swallows = self._bytes.find(self._bytes[:ALIKE_BYTES], 1, header.size) >= 0
        return "nested_record" if swallows and header.kind in WITH_IMAGE else ""
