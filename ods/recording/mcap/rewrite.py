"""Completes a truncated or damaged segment: all that can be read of it is written to a new one, which replaces it."""

import os
from collections import Counter
from pathlib import Path

from ods.recording.errors import RecordingError
from ods.recording.mcap.reader import ODS, Recorded, Recording, open_recording
from ods.recording.mcap.segment import Logged, Segment
from ods.recording.mcap.session import CHUNK_BYTES
from ods.recording.mcap.topics import MESSAGES

CUT_OFF = frozenset({"torn"})
"""Losses of a segment whose recorder was killed: what is lost was never whole."""


def rewrite(path: Path) -> tuple[int, "Counter[str]", Path | None]:
    """Complete one segment; return the messages in it, what was lost, and the file as it was if more was damaged than
    its end: another program may save more of it. Raises RecordingError, OSError.
    """
    recording = open_recording(path)
    part, segment = path.with_name(f"{path.name}.new"), _begun(path, recording)
    try:
        for name, data in recording.attachments.items():
            segment.enclose(name, "application/octet-stream", data, 0)
        count = sum(_written(segment, each, recording.losses) for each in recording.messages())
        segment.finish()
    except BaseException:
        segment.close()
        part.unlink(missing_ok=True)
        raise
    kept = path.with_name(f"{path.name}.damaged") if recording.losses.keys() - CUT_OFF else None
    if kept is not None and not kept.exists():
        os.link(path, kept)
    part.replace(path)
    return count, recording.losses, kept


def _begun(path: Path, recording: Recording) -> Segment:
    """Raises RecordingError, OSError."""
    try:
        offset_ns = int(recording.metadata[ODS]["utc_offset_ns"])
    except (KeyError, ValueError) as error:
        raise RecordingError(f"{path}: contains no time stamps: nothing can be repaired") from error
    part = path.with_name(f"{path.name}.new")
    part.unlink(missing_ok=True)
    return Segment(part, offset_ns, recording.metadata)


def _written(segment: Segment, message: Recorded, losses: "Counter[str]") -> bool:
    if message.topic not in MESSAGES:
        losses["unknown_channels"] += 1
        return False
    segment.write([Logged(message.topic, message.utc_ns, message.data)])
    if message.topic == "ping" or segment.waiting_bytes >= CHUNK_BYTES:
        segment.close_chunk()
    return True
