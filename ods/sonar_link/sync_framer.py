"""Packets that begin with a sync word and say their size, found in a byte stream. Sans-IO.

A sonar's own framer says how a header looks and when it is believed. Where it is not, the search goes on just behind
the false sync word, so that a false header swallows little. Every loss is counted.
"""

import re
from abc import ABC, abstractmethod
from collections import Counter, deque
from typing import ClassVar, Generic, NamedTuple, Protocol, TypeVar

MAX_PACKET_BYTES = 4 * 1024 * 1024
"""No sonar here sends more: the Norbit's document has 1,048,768."""
CHECKED_AGAIN = 8
"""Most times that a byte may be checked."""


class Sized(Protocol):
    """A packet's header, unpacked."""

    @property
    def size(self) -> int:
        """Bytes of the whole packet."""


HeaderT = TypeVar("HeaderT", bound=Sized)
FoundT = TypeVar("FoundT")


class Packet(NamedTuple, Generic[HeaderT]):
    """One whole packet."""

    header: HeaderT
    data: bytes
    """All of it, header included: places in it count from its start."""
    first_ns: int
    """When its first byte was read."""
    last_ns: int


class ChecksumBudget:
    """Bounds what checksums cost: headers within false packets, each with one of all that follows, cost it each time.

    What would cost more than `CHECKED_AGAIN` times the bytes that came is taken to be no packet.
    """

    def __init__(self, max_packet_bytes: int) -> None:
        self._most = CHECKED_AGAIN * max_packet_bytes
        self._left = max_packet_bytes

    def earn(self, count: int) -> None:
        """Record the number of received bytes."""
        self._left = min(self._left + CHECKED_AGAIN * count, self._most)

    def allows(self, size: int) -> bool:
        """Return whether a packet of this number of bytes may be checked, and subtract that."""
        if size > self._left:
            return False
        self._left -= size
        return True


class Unended(ABC, Generic[FoundT]):
    """What of a framer does not depend on how its packets look: giving up those that do not end."""

    @property
    @abstractmethod
    def waiting_since_ns(self) -> int | None:
        """When the first byte of the packet under way was read; None when none is."""

    @abstractmethod
    def give_up(self) -> list[FoundT]:
        """Disbelieve the header of the packet under way; return the packets found behind it."""

    def give_up_late(self, now_ns: int, timeout_ns: int) -> list[FoundT]:
        """Give up what began longer ago than that; return the packets found behind it."""
        found: list[FoundT] = []
        while (since_ns := self.waiting_since_ns) is not None and now_ns - since_ns > timeout_ns:
            found += self.give_up()
        return found

    def give_up_all(self) -> list[FoundT]:
        """Give up whatever is under way; return the packets found in it."""
        found: list[FoundT] = []
        while self.waiting_since_ns is not None:
            found += self.give_up()
        return found


class SyncFramer(Unended[Packet[HeaderT]], Generic[HeaderT]):
    """Turns chunks of a stream into packets, in any chunking the same.

    Counts `records` (whole packets), `garbage_bytes` (bytes of no packet), `truncated_record`, `unknown_message` (a
    sync word without a known kind), and what the sonar's own framer says.
    """

    sync: ClassVar[bytes]
    known_head: ClassVar["re.Pattern[bytes]"]
    """A sync word with a known kind: searched for at once, as a stream of sync words alone costs much else."""
    head_bytes: ClassVar[int]
    """From the sync word to the kind, both included."""
    header_bytes: ClassVar[int]

    def __init__(self, counters: "Counter[str] | None" = None) -> None:
        self.counters: Counter[str] = Counter() if counters is None else counters
        self._bytes = bytearray()
        self._start = 0  # position of the buffer's first byte in the stream
        self._arrivals: deque[tuple[int, int]] = deque()  # (position behind a chunk, when it was read)

    @abstractmethod
    def _header(self) -> HeaderT:
        """Unpack the header at the front of the buffer, which has `header_bytes`."""

    @abstractmethod
    def _fault_of_head(self) -> str | None:
        """Return why the buffer's front begins no packet; '' when it does; None when there are too few bytes."""

    @abstractmethod
    def _fault_of_content(self, header: HeaderT) -> str:
        """Return why the whole packet at the front cannot be one, '' when it can."""

    def feed(self, data: bytes | bytearray | memoryview, t_ns: int = 0) -> list[Packet[HeaderT]]:
        """Take the next bytes of the stream, read at `t_ns`; return the packets that they complete."""
        if not len(data):
            return []
        self._bytes += data
        self._arrivals.append((self._start + len(self._bytes), t_ns))
        return self._packets()

    @property
    def waiting_since_ns(self) -> int | None:
        """When the first byte of the packet under way was read; None when none is."""
        return self._arrivals[0][1] if self._bytes.startswith(self.sync) else None

    @property
    def missing_bytes(self) -> int:
        """Bytes that must come before the packet under way can be complete; 0 when none is under way."""
        if self.waiting_since_ns is None or len(self._bytes) < self.header_bytes:
            return 0
        return self._header().size - len(self._bytes)

    def give_up(self) -> list[Packet[HeaderT]]:
        """Disbelieve the header of the packet under way; return the packets found behind it."""
        if self.waiting_since_ns is None:
            return []
        self.counters["truncated_record"] += 1
        self._discard(len(self.sync))
        return self._packets()

    def flush(self) -> list[Packet[HeaderT]]:
        """End the stream: give up whatever is under way; return the packets found in it. Feeding may go on."""
        found = self.give_up_all()
        self._discard(len(self._bytes))
        return found

    def _packets(self) -> list[Packet[HeaderT]]:
        found: list[Packet[HeaderT]] = []
        while self._find_sync():
            fault = self._fault_of_head()
            if fault is None:
                break
            header = self._header()
            if not fault and len(self._bytes) < header.size:
                break
            fault = fault or self._fault_of_content(header)
            if fault:
                self.counters[fault] += 1
                self._discard(len(self.sync))
            else:
                found.append(self._take(header))
        return found

    def _find_sync(self) -> bool:
        """Drop what cannot begin a packet; return whether a sync word comes first."""
        head = self.known_head.search(self._bytes)
        undecided = max(0, len(self._bytes) - self.head_bytes + 1)  # behind it a head's kind is not there yet
        at = head.start() if head else self._bytes.find(self.sync, undecided)
        tail = next((n for n in range(len(self.sync) - 1, 0, -1) if self._bytes.endswith(self.sync[:n])), 0)
        begin = at if at >= 0 else len(self._bytes) - tail
        if unknown := self._bytes.count(self.sync, 0, begin):
            self.counters["unknown_message"] += unknown
        self._discard(begin)
        return at >= 0

    def _take(self, header: HeaderT) -> Packet[HeaderT]:
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
