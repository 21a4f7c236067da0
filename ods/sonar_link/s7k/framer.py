"""Finds s7k records in an arbitrary byte stream. Sans-IO: bytes go in, whole records come out, every loss is counted.

A header is believed only when version, offsets and size fit, and its record only when the checksum fits (where the
flags say that there is one). Otherwise the search goes on just behind the false sync word, so that a false header never
swallows a true record. The running byte sum is kept beside the buffer: a checksum costs one subtraction, however many
false headers claim the same bytes.
"""

from collections import Counter, deque

import numpy as np

from ods.sonar_link.s7k import drf
from ods.sonar_link.s7k.drf import RecordHeader, S7kRecord
from ods.sonar_link.s7k.loss import Loss
from ods.sonar_link.sync_framer import Unended

MAX_RECORD_BYTES = 4 * 1024 * 1024
MIN_RECORD_BYTES = drf.RECORD_HEADER_BYTES + drf.CHECKSUM_BYTES
MIN_OFFSET = drf.RECORD_HEADER_BYTES - drf.SYNC_AT
FRAME_START = drf.RECORD_VERSION.to_bytes(2, "little") + MIN_OFFSET.to_bytes(2, "little") + drf.SYNC_WORD
KEPT_TAIL = drf.SYNC_AT + len(drf.SYNC_WORD) - 1
"""The longest beginning of a header that cannot be recognized yet."""
_SUM_BYTES = 4
_SUM_MASK = 0xFFFFFFFF


class RecordFramer(Unended[S7kRecord]):
    """Turns chunks of a stream into records, in any chunking the same.

    Counters: records, of them unchecked_records (without checksum); garbage_bytes (bytes of no record); and one for
    each reason to disbelieve a header: bad_version, bad_offset, short_record, overlong_record, bad_checksum,
    truncated_record, nested_record (claims no checksum and holds the start of another record).
    """

    def __init__(self, max_record_bytes: int = MAX_RECORD_BYTES, counters: "Counter[str] | None" = None) -> None:
        self.counters: Counter[str] = Counter() if counters is None else counters
        self._max_record_bytes = max_record_bytes
        self._bytes = bytearray()
        self._sums = bytearray()  # uint32 little endian: sum modulo 2**32 of all bytes up to and with each one
        self._sum_before = 0  # the same for the byte before the buffer
        self._start = 0  # position of the buffer's first byte in the stream
        self._arrivals: deque[tuple[int, int]] = deque()  # (position behind a chunk, when it was read)

    def feed(self, data: bytes | bytearray | memoryview, t_ns: int = 0) -> list[S7kRecord]:
        """Take the next bytes of the stream, read at `t_ns`; return the records that they complete."""
        if not len(data):
            return []
        sums = np.cumsum(np.frombuffer(data, np.uint8), dtype="<u4")  # wraps, as the checksum does
        sums += np.uint32(self._sum_at(len(self._bytes)))
        self._bytes += data
        self._sums += sums.tobytes()
        self._arrivals.append((self._start + len(self._bytes), t_ns))
        return self._records()

    @property
    def waiting_since_ns(self) -> int | None:
        """When the first byte of the record under way was read; None when none is."""
        under_way = self._bytes.startswith(drf.SYNC_WORD, drf.SYNC_AT)
        return self._arrivals[0][1] if under_way else None

    @property
    def missing_bytes(self) -> int:
        """Bytes that must come before the record under way can be complete; 0 when none is under way."""
        if self.waiting_since_ns is None or len(self._bytes) < drf.RECORD_HEADER_BYTES:
            return 0
        return drf.unpack_record_header(self._bytes).size - len(self._bytes)

    def give_up(self) -> list[S7kRecord]:
        """Disbelieve the header of the record under way; return the records found behind it."""
        if self.waiting_since_ns is None:
            return []
        self.counters[Loss.TRUNCATED_RECORD.value] += 1
        self._discard(drf.SYNC_AT)
        return self._records()

    def flush(self) -> list[S7kRecord]:
        """End the stream: give up whatever is under way; return the records found in it. Feeding may go on."""
        records = self.give_up_all()
        self._discard(len(self._bytes))
        return records

    def _records(self) -> list[S7kRecord]:
        found: list[S7kRecord] = []
        while self._find_sync() and len(self._bytes) >= drf.RECORD_HEADER_BYTES:
            header = drf.unpack_record_header(self._bytes)
            fault = self._fault(header)
            if fault is None and len(self._bytes) < header.size:
                break
            fault = fault or self._fault_of_content(header)
            if fault is not None:
                self.counters[fault.value] += 1
                self._discard(drf.SYNC_AT)  # the next header may begin as soon as its sync word is another one
            else:
                found.append(self._take(header))
        return found

    def _find_sync(self) -> bool:
        """Drop what cannot be part of a header; return whether a sync word stands where a header has it."""
        at = self._bytes.find(drf.SYNC_WORD, drf.SYNC_AT)
        self._discard(at - drf.SYNC_AT if at >= 0 else len(self._bytes) - KEPT_TAIL)
        return at >= 0

    def _fault(self, header: RecordHeader) -> Loss | None:
        """Return why the header cannot be one, None when it can."""
        if header.version != drf.RECORD_VERSION:
            return Loss.BAD_VERSION
        if header.size < MIN_RECORD_BYTES:
            return Loss.SHORT_RECORD
        if header.size > self._max_record_bytes:
            return Loss.OVERLONG_RECORD
        body_at = drf.SYNC_AT + header.offset
        body_end = header.optional_offset or header.size - drf.CHECKSUM_BYTES
        if header.offset < MIN_OFFSET or not body_at <= body_end <= header.size - drf.CHECKSUM_BYTES:
            return Loss.BAD_OFFSET
        return None

    def _fault_of_content(self, header: RecordHeader) -> Loss | None:
        """Return why the whole record cannot be one, None when it can."""
        if not header.flags & drf.CHECKSUM_VALID:
            swallows = self._bytes.find(FRAME_START, 1, header.size) >= 0
            return Loss.NESTED_RECORD if swallows else None
        end = header.size - drf.CHECKSUM_BYTES
        stated = int.from_bytes(self._bytes[end : header.size], "little")
        fits = (self._sum_at(end) - self._sum_before) & _SUM_MASK == stated
        return None if fits else Loss.BAD_CHECKSUM

    def _take(self, header: RecordHeader) -> S7kRecord:
        body_end = header.optional_offset or header.size - drf.CHECKSUM_BYTES
        record = S7kRecord(
            record_type=header.record_type,
            device=header.device,
            time_ns=drf.decode_time(header.time),
            body=bytes(self._bytes[drf.SYNC_AT + header.offset : body_end]),
            first_ns=self._arrivals[0][1],
            last_ns=self._arrival_of(self._start + header.size - 1),
        )
        self.counters["records"] += 1
        if not header.flags & drf.CHECKSUM_VALID:
            self.counters["unchecked_records"] += 1
        self._drop(header.size)
        return record

    def _arrival_of(self, position: int) -> int:
        return next(t_ns for end, t_ns in self._arrivals if position < end)

    def _sum_at(self, count: int) -> int:
        """Return the running sum with the first `count` bytes of the buffer."""
        if count == 0:
            return self._sum_before
        return int.from_bytes(self._sums[_SUM_BYTES * (count - 1) : _SUM_BYTES * count], "little")

    def _discard(self, count: int) -> None:
        if count > 0:
            self.counters["garbage_bytes"] += count
            self._drop(count)

    def _drop(self, count: int) -> None:
        self._sum_before = self._sum_at(count)
        del self._bytes[:count]
        del self._sums[: _SUM_BYTES * count]
        self._start += count
        while self._arrivals and self._arrivals[0][0] <= self._start:
            self._arrivals.popleft()
