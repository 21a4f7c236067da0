"""Finds Oculus messages in a byte stream. Sans-IO: bytes go in, whole messages come out, every loss is counted.

The messages have no checksum. A header is believed when its kind is known and its size possible; a simple ping result
only when all its sizes and counts fit each other, which is known as soon as its first 122 or 202 bytes are there, and
when no other one begins in it. Otherwise the search goes on just behind the false sync word, so that a false header
swallows little.
"""

import re
from collections import Counter, deque
from typing import NamedTuple

from ods.sonar_link.oculus import messages
from ods.sonar_link.oculus.messages import CHECK_WORD, HEADER_BYTES, Buffer, Header, MessageKind

KNOWN_KINDS = frozenset(MessageKind)
MAX_MESSAGE_BYTES = 4 * 1024 * 1024
MAX_OTHER_BYTES = 65536
"""Longest message without an image."""
WITH_IMAGE = (MessageKind.PING, MessageKind.FULL_PING)
KIND_AT, KIND_BYTES = 6, 2
_KNOWN_HEAD = re.compile(
    CHECK_WORD + b".{%d}" % (KIND_AT - len(CHECK_WORD))
    + b"(?:%b)" % b"|".join(re.escape(kind.to_bytes(KIND_BYTES, "little")) for kind in sorted(KNOWN_KINDS)),
    re.DOTALL,
)  # fmt: skip
"""A sync word with a known kind: searched for at once, as a stream of sync words alone costs 1.4 us a byte else."""
ALIKE_BYTES = 10
"""Of the header: sync word, source, destination, kind and version, the same in all results of one sonar."""


class Message(NamedTuple):
    """One whole message."""

    header: Header
    data: bytes
    """All of it, header included: places in it count from its start."""
    first_ns: int
    """When its first byte was read."""
    last_ns: int


def fault_of(data: Buffer, at: int = 0, max_bytes: int = MAX_MESSAGE_BYTES) -> str | None:
    """Say why the bytes from `at` on are no message; '' when they are, or its beginning; None when too few tell."""
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


class Framer:
    """Turns chunks of a stream into messages, in any chunking the same.

    Counters: records (whole messages); garbage_bytes (bytes of no message); and one for each reason to disbelieve a
    header: unknown_message, overlong_record, short_record, bad_ping, truncated_record, nested_record (the start of
    another message of the kind lies in it: its own end was lost).
    """

    def __init__(self, max_message_bytes: int = MAX_MESSAGE_BYTES, counters: "Counter[str] | None" = None) -> None:
        self.counters: Counter[str] = Counter() if counters is None else counters
        self._max_message_bytes = max_message_bytes
        self._bytes = bytearray()
        self._start = 0  # position of the buffer's first byte in the stream
        self._arrivals: deque[tuple[int, int]] = deque()  # (position behind a chunk, when it was read)

    def feed(self, data: bytes | bytearray | memoryview, t_ns: int = 0) -> list[Message]:
        """Take the next bytes of the stream, read at `t_ns`; return the messages that they complete."""
        if not len(data):
            return []
        self._bytes += data
        self._arrivals.append((self._start + len(self._bytes), t_ns))
        return self._messages()

    @property
    def waiting_since_ns(self) -> int | None:
        """When the first byte of the message under way was read; None when none is."""
        return self._arrivals[0][1] if self._bytes.startswith(CHECK_WORD) else None

    @property
    def missing_bytes(self) -> int:
        """Bytes that must come before the message under way can be complete; 0 when none is under way."""
        if self.waiting_since_ns is None or len(self._bytes) < HEADER_BYTES:
            return 0
        return messages.unpack_header(self._bytes).size - len(self._bytes)

    def give_up(self) -> list[Message]:
        """Disbelieve the header of the message under way; return the messages found behind it."""
        if self.waiting_since_ns is None:
            return []
        self.counters["truncated_record"] += 1
        self._discard(len(CHECK_WORD))
        return self._messages()

    def flush(self) -> list[Message]:
        """End the stream: give up whatever is under way; return the messages found in it. Feeding may go on."""
        found: list[Message] = []
        while self.waiting_since_ns is not None:
            found += self.give_up()
        self._discard(len(self._bytes))
        return found

    def _messages(self) -> list[Message]:
        found: list[Message] = []
        while self._find_sync():
            fault = fault_of(self._bytes, 0, self._max_message_bytes)
            if fault is None:
                break
            header = messages.unpack_header(self._bytes)
            if not fault and len(self._bytes) < header.size:
                break
            fault = fault or self._fault_of_content(header)
            if fault:
                self.counters[fault] += 1
                self._discard(len(CHECK_WORD))
            else:
                found.append(self._take(header))
        return found

    def _fault_of_content(self, header: Header) -> str:
        """Say why the whole message cannot be one, '' when it can."""
        swallows = self._bytes.find(self._bytes[:ALIKE_BYTES], 1, header.size) >= 0
        return "nested_record" if swallows and header.kind in WITH_IMAGE else ""

    def _find_sync(self) -> bool:
        """Drop what cannot begin a message; tell whether a sync word comes first."""
        head = _KNOWN_HEAD.search(self._bytes)
        untold = max(0, len(self._bytes) - KIND_AT - KIND_BYTES + 1)  # behind it a head's kind is not there yet
        at = head.start() if head else self._bytes.find(CHECK_WORD, untold)
        tail = len(CHECK_WORD) - 1 if self._bytes.endswith(CHECK_WORD[:-1]) else 0
        begin = at if at >= 0 else len(self._bytes) - tail
        if unknown := self._bytes.count(CHECK_WORD, 0, begin):
            self.counters["unknown_message"] += unknown
        self._discard(begin)
        return at >= 0

    def _take(self, header: Header) -> Message:
        last_ns = self._arrival_of(self._start + header.size - 1)
        message = Message(header, bytes(self._bytes[: header.size]), self._arrivals[0][1], last_ns)
        self.counters["records"] += 1
        self._drop(header.size)
        return message

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
