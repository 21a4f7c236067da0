"""`ods record --finish`: completes recordings that were cut off."""

import fcntl
import os
import struct
import zlib
from pathlib import Path

from mcap.opcode import Opcode

from ods.base.errors import one_line
from ods.base.files.in_file import opened
from ods.recording.errors import RecordingError
from ods.recording.mcap.framing import MAGIC, MB, RECORD
from ods.recording.mcap.reader import SUFFIX, Recording, open_recording
from ods.recording.mcap.rewrite import rewrite
from ods.recording.mcap.session import is_finished
from ods.sonar_link.files.s7k.writer import repair_s7k

FOOTER = struct.Struct("<QQI")
"""Where the summary begins, and its index, and the CRC-32 of the bytes from there to this one."""
CHECKSUM_BYTES = 4


def repair(path: Path) -> None:
    """Complete a .s7k file, a segment, or the segments in a folder; say what became of each. Raises RecordingError."""
    try:
        if path.is_dir():
            segments = open_recording(path).segments
            for each in segments:
                _repair_segment(each)
        elif path.suffix == SUFFIX:
            _repair_segment(path)
        else:
            print(f"{path}: complete, {repair_s7k(path)} records")
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise RecordingError(f"{path}: {one_line(error)}") from error


def _repair_segment(path: Path) -> None:
    recording = open_recording(path)
    finished = is_finished(path)
    if not finished and _is_being_written(path):
        raise RecordingError(f"{path}: is being written")
    if finished:
        _look_through(recording, path)
    if finished and not recording.losses:
        print(f"{path}: is complete already")
        return
    messages, losses, kept = rewrite(path)
    lost = "".join(f", {name} {count}" for name, count in sorted(losses.items()))
    print(f"{path}: complete, {messages} messages{lost}{f'; original kept as {kept}' if kept else ''}")


def _look_through(recording: Recording, path: Path) -> None:
    """Count in its losses what is damaged between the two ends of a segment."""
    for _ in recording.messages():
        pass
    assert recording.metadata is not None  # looks at attachments, too
    if not _has_whole_summary(path):
        recording.losses["bad_records"] += 1


def _has_whole_summary(path: Path) -> bool:
    """Return whether the index at a segment's end has the checksum of its footer; one without counts too."""
    with opened(path) as file:
        footer_at = file.seek(-(RECORD.size + FOOTER.size + len(MAGIC)), os.SEEK_END)
        opcode, length = RECORD.unpack(file.read(RECORD.size))
        start, _, checksum = FOOTER.unpack(file.read(FOOTER.size))
        if (opcode, length) != (Opcode.FOOTER, FOOTER.size) or start > footer_at:
            return False
        if not start or not checksum:
            return True
        file.seek(start)
        found, left = 0, footer_at + RECORD.size + FOOTER.size - CHECKSUM_BYTES - start
        while left > 0:
            part = file.read(min(left, MB))
            found, left = zlib.crc32(part, found), left - len(part)
        return found == int(checksum)


def _is_being_written(path: Path) -> bool:
    with opened(path) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:  # some file systems have no locks
            return False
    return False
