"""One recording: a folder of segments, one after the other, from the same start of the computer."""

import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

from ods.base import clock
from ods.base.files.in_file import opened
from ods.recording.errors import RecordingError
from ods.recording.facts import boot_id
from ods.recording.inbox import Received
from ods.recording.mcap.framing import LONGEST_MESSAGE_BYTES, MAGIC
from ods.recording.mcap.reader import ODS, SUFFIX, open_recording
from ods.recording.mcap.segment import Logged, Segment
from ods.recording.mcap.topics import process_of
from ods.runtime import bus

CHUNK_BYTES = 256 * 1024
CHUNK_NS = clock.NS
"""Without pings a chunk ends when it is so large or so old."""
STEP_NS = clock.NS // 10
"""A change of UTC by less is no step."""


class Session:
    """Writes messages into segments. Methods raise OSError: what they were given is then not written."""

    def __init__(self, folder: Path, facts: Mapping[str, str], segment_ns: int) -> None:
        """`folder`: there already; segments in it go on being counted."""
        self.folder = folder
        self.segments = self.left_out = 0
        """So far: files begun; messages too long for one."""
        self._facts = dict(facts)
        self._offset_ns = self._utc_ns = int(facts["utc_offset_ns"])
        self._segment_ns = segment_ns
        self._number = _next_number(folder)
        self._segment: Segment | None = None
        self._begun_ns = self._chunk_ns = 0
        self._attachments: list[tuple[str, str, bytes]] = []
        self._senders: set[tuple[str, int]] = set()
        self._steps = 0

    @property
    def path(self) -> Path | None:
        """Of the segment that is being written."""
        return self._segment.path if self._segment else None

    @property
    def fd(self) -> int | None:
        """Likewise, for fdatasync."""
        return self._segment.fd if self._segment else None

    def enclose(self, name: str, media_type: str, data: bytes) -> None:
        """Put a file into the next segment."""
        self._attachments.append((name, media_type, data))

    def write(self, messages: Sequence[Received]) -> None:
        """Write messages, in order of time."""
        now_ns = messages[-1].log_ns
        segment = self._segment_at(now_ns)
        fitting = [message for message in messages if len(message.data) <= LONGEST_MESSAGE_BYTES]
        segment.write(Logged(each.topic, max(0, each.log_ns + self._offset_ns), each.data) for each in fitting)
        self.left_out += len(messages) - len(fitting)
        old = now_ns - self._chunk_ns >= CHUNK_NS or segment.waiting_bytes >= CHUNK_BYTES
        with suppress(OSError):  # they are written, and a next attempt says whether the disk is full
            if old or any(message.topic == "ping" for message in messages):
                self._chunk_ns = now_ns
                segment.close_chunk()
            self._tell_senders(segment, messages)

    def look_around(self) -> None:
        """Note a step of UTC, and leave a segment that somebody removed."""
        if self._segment is None:
            return
        offset_ns = clock.utc_offset_ns()
        if abs(offset_ns - self._utc_ns) > STEP_NS:
            self._steps += 1
            clocks = {"at_ns": str(clock.monotonic_ns()), "utc_offset_ns": str(offset_ns)}
            self._segment.add_metadata(f"utc step {self._steps}", clocks)
            self._utc_ns = offset_ns
        if not _is_there(self._segment):
            self.abandon()

    def abandon(self) -> None:
        """Begin a new segment with the next message; this one stays as a killed recorder leaves it."""
        if self._segment:
            self._segment.close()
            self._segment = None

    def finish(self) -> None:
        """Complete the segment."""
        if self._segment:
            segment, self._segment = self._segment, None
            segment.finish()

    def _segment_at(self, now_ns: int) -> Segment:
        if self._segment and now_ns - self._begun_ns >= self._segment_ns:
            self.finish()
        if self._segment is None:
            self._segment = self._begun(now_ns)
            self._begun_ns = self._chunk_ns = now_ns
        return self._segment

    def _begun(self, now_ns: int) -> Segment:
        path = self.folder / f"{self._number:05d}{SUFFIX}"
        segment = Segment(path, self._offset_ns, {ODS: self._facts})
        try:
            for name, media_type, data in self._attachments:
                segment.enclose(name, media_type, data, now_ns + self._offset_ns)
        except OSError:
            segment.close()
            path.unlink(missing_ok=True)
            raise
        self._attachments = [each for each in self._attachments if each[0] == "config.toml"]
        self._number += 1
        self.segments += 1
        return segment

    def _tell_senders(self, segment: Segment, messages: Iterable[Received]) -> None:
        """Note each process that begins."""
        for message in messages:
            if message.topic == bus.HEALTH and (sender := process_of(message.data)) not in self._senders:
                self._senders.add(sender)
                name, pid = sender
                if not name:
                    continue
                segment.add_metadata(
                    f"process {name} {pid}", {"process": name, "pid": str(pid), "at_ns": str(message.log_ns)}
                )


def new_folder(parent: Path) -> Path:
    """Return a folder for a recording: that of a recorder that was killed since the computer started, or a new one.

    Raises OSError.
    """
    parent.mkdir(parents=True, exist_ok=True)
    for path in sorted(parent.glob(f"*/*{SUFFIX}"))[-1:]:
        if not is_finished(path) and _boot_of(path) == boot_id():
            return path.parent
    stem = datetime.fromtimestamp(clock.utc_ns() // clock.NS, UTC).strftime("%Y%m%dT%H%M%SZ")
    folder, number = parent / stem, 1
    while folder.exists():
        number += 1
        folder = parent / f"{stem}-{number}"
    folder.mkdir()
    return folder


def is_finished(path: Path) -> bool:
    """Return whether a segment has its end. Raises OSError."""
    with opened(path) as file:
        size = os.fstat(file.fileno()).st_size
        file.seek(max(0, size - len(MAGIC)))
        return size > 2 * len(MAGIC) and file.read() == MAGIC


def _boot_of(path: Path) -> str:
    try:
        return open_recording(path).metadata[ODS]["boot_id"]
    except (RecordingError, KeyError):
        return ""


def _next_number(folder: Path) -> int:
    numbers = [int(path.stem) for path in folder.glob(f"*{SUFFIX}") if path.stem.isdecimal()]
    return max(numbers, default=-1) + 1


def _is_there(segment: Segment) -> bool:
    try:
        return os.path.samestat(segment.path.stat(), os.fstat(segment.fd))
    except OSError:
        return False
