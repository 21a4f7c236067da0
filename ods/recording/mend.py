"""`ods record --finish`: completes recordings that were cut off."""

import fcntl
from pathlib import Path

from ods.base.errors import one_line
from ods.base.in_file import opened
from ods.recording.errors import RecordingError
from ods.recording.mcap.reader import SUFFIX, open_recording
from ods.recording.mcap.rewrite import rewrite
from ods.recording.mcap.session import is_finished
from ods.sonar_link.files.s7k.writer import mend_s7k


def mend(path: Path) -> None:
    """Complete a .s7k file, a segment, or the segments in a folder; say what became of each. Raises RecordingError."""
    try:
        if path.is_dir():
            segments = open_recording(path).segments
            for each in segments:
                _mend_segment(each)
        elif path.suffix == SUFFIX:
            _mend_segment(path)
        else:
            print(f"{path}: complete, {mend_s7k(path)} records")
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise RecordingError(f"{path}: {one_line(error)}") from error


def _mend_segment(path: Path) -> None:
    recording = open_recording(path)
    finished = is_finished(path)
    if not finished and _is_being_written(path):
        raise RecordingError(f"{path}: is being written")
    if finished:
        for _ in recording.messages():  # finds what is damaged between its two ends
            pass
    if finished and not recording.losses:
        print(f"{path}: is complete")
        return
    messages, losses, kept = rewrite(path)
    lost = "".join(f", {name} {count}" for name, count in sorted(losses.items()))
    print(f"{path}: complete, {messages} messages{lost}{f'; as it was: {kept}' if kept else ''}")


def _is_being_written(path: Path) -> bool:
    with opened(path) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:  # some file systems have no locks
            return False
    return False
