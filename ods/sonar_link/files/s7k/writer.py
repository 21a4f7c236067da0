"""Writes .s7k files record by record, so that a crash at any moment costs the record being written and no other."""

import contextlib
import fcntl
import io
import mmap
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from ods.messages import Ping
from ods.sonar_link.files.s7k.catalogue import (
    FILE_CATALOGUE,
    encode_catalogue,
    encode_entry,
    encode_file_header,
    with_catalogue,
)
from ods.sonar_link.s7k import drf, records

SONAR_DEVICE = records.DEVICE
"""That of the records of pings."""


class S7kWriter:
    """One file: header at once, records as they come, the catalogue and the header's pointer to it on `close`.

    `file` is unbuffered, so what `write` returned from is safe from the death of this process. Only `sync` and `close`
    make it safe from a loss of power.
    """

    def __init__(
        self, file: io.FileIO, name: str, utc_ns: int, devices: Sequence[drf.DeviceId] = (SONAR_DEVICE,)
    ) -> None:
        """Write the file header; `name`: the recording's. Raises OSError, ValueError for a time without a 7KTIME."""
        self.size = 0
        """Bytes of the file."""
        self._file = file
        self._utc_ns = utc_ns
        self._entries = bytearray()
        self._header = encode_file_header(utc_ns, name, devices)
        _lock(file)
        self.write(self._header)

    def write(self, frames: bytes) -> None:
        """Append framed records. Raises OSError; the file then ends with the last whole record."""
        entries = b"".join(encode_entry(frames[at : at + size], self.size + at) for at, size in whole_records(frames))
        try:
            _write_all(self._file, frames)
        except OSError:
            with contextlib.suppress(OSError):
                self._file.truncate(self.size)
                self._file.seek(self.size)
            raise
        self.size += len(frames)
        self._entries += entries

    def write_ping(self, ping: Ping) -> None:
        """Append the records of a ping. Raises ValueError when the format cannot carry it, ArithmeticError, OSError."""
        if ping.range_grid is not None:
            raise ValueError(f"ping {ping.ping_number}: a range image, which s7k has no record for")
        self.write(records.encode_ping(ping, recorded=True))

    def sync(self) -> None:
        """Make what is written safe from a loss of power; takes as long as the disk takes. Raises OSError."""
        os.fdatasync(self._file.fileno())

    def close(self) -> None:
        """Write the catalogue and close the file. Raises OSError; without a catalogue the file is still whole."""
        with self._file:
            _append_catalogue(self._file, self._header, bytes(self._entries), self.size, self._utc_ns)


def write_s7k(path: Path, pings: Iterable[Ping]) -> None:
    """Write pings of any geometry. Raises ValueError when one cannot be carried by the format, OSError on the disk."""
    with path.open("wb", buffering=0) as file:
        writer: S7kWriter | None = None
        for ping in pings:
            writer = writer or S7kWriter(file, path.name, ping.utc_ns)
            writer.write_ping(ping)
        if writer is not None:
            writer.close()


def repair_s7k(path: Path) -> int:
    """Give a file of `S7kWriter` that was cut off its catalogue; return the number of its records.

    Bytes behind the last whole record are removed. A file that has its catalogue is left as it is. Raises OSError, and
    ValueError for a file that another program began, or that is still being written.
    """
    with path.open("r+b", buffering=0) as file:
        if not _lock(file):
            raise ValueError("is being written")
        found = _survey(file)
        if not found.complete:
            utc_ns = drf.decode_time(drf.unpack_record_header(found.header).time)
            with_catalogue(found.header, 0, 0)  # says whether it can be done, before anything is changed
            file.truncate(found.end)
            file.seek(found.end)
            _append_catalogue(file, found.header, found.entries, found.end, utc_ns)
    return found.records


class _Survey(NamedTuple):
    """Contents of a file before its catalogue."""

    header: bytes
    """The file header's frame."""
    records: int
    entries: bytes
    """Of the records, for the catalogue."""
    end: int
    """Of the last whole record."""
    complete: bool
    """The catalogue is there, and the header points to it."""


def _survey(file: io.FileIO) -> _Survey:
    """Raises ValueError when the file does not begin with a complete record."""
    if not os.fstat(file.fileno()).st_size:
        raise ValueError("empty")
    with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        places = list(whole_records(data))
        if not places or places[0][0] != 0:
            raise ValueError("does not begin with a complete record")
        header = data[: places[0][1]]
        at, size = places[-1]
        complete = False
        if drf.unpack_record_header(data[at : at + drf.RECORD_HEADER_BYTES]).record_type == FILE_CATALOGUE:
            places.pop()
            complete = header == with_catalogue(header, size, at)
        entries = b"".join(encode_entry(data[at : at + drf.RECORD_HEADER_BYTES], at) for at, _ in places)
    return _Survey(header, len(places), entries, sum(places[-1]), complete)


def whole_records(data: bytes | mmap.mmap) -> Iterator[tuple[int, int]]:
    """Yield place and size of each whole record with a valid checksum, whatever stands between them."""
    at = 0
    while 0 <= at <= len(data) - drf.RECORD_HEADER_BYTES:
        size = _record_size(data, at)
        if size:
            yield at, size
            at += size
        else:
            at = max(data.find(drf.SYNC_WORD, at + drf.SYNC_AT + 1) - drf.SYNC_AT, -1)


def _record_size(data: bytes | mmap.mmap, at: int) -> int:
    """Return the size of the whole record at `at`, 0 when there is none."""
    if data[at + drf.SYNC_AT : at + drf.SYNC_AT + len(drf.SYNC_WORD)] != drf.SYNC_WORD:
        return 0
    header = drf.unpack_record_header(data[at : at + drf.RECORD_HEADER_BYTES])
    end = at + header.size - drf.CHECKSUM_BYTES
    if header.size < drf.RECORD_HEADER_BYTES + drf.CHECKSUM_BYTES or end + drf.CHECKSUM_BYTES > len(data):
        return 0
    stated = int.from_bytes(data[end : end + drf.CHECKSUM_BYTES], "little")
    return header.size if stated == drf.checksum_of(data[at:end]) else 0


def _append_catalogue(file: io.FileIO, header: bytes, entries: bytes, at: int, utc_ns: int | None) -> None:
    catalogue = encode_catalogue(utc_ns, entries)
    pointing = with_catalogue(header, len(catalogue), at)
    try:
        _write_all(file, catalogue)
        os.fdatasync(file.fileno())  # the header must not point at what a loss of power took away
    except OSError:
        with contextlib.suppress(OSError):
            file.truncate(at)
        raise
    os.pwrite(file.fileno(), pointing, 0)
    os.fdatasync(file.fileno())


def _lock(file: io.FileIO) -> bool:
    """Take the file's lock; return whether no other process has it. File systems without locks do not matter."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        pass
    return True


def _write_all(file: io.FileIO, data: bytes) -> None:
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) :]
