"""Completes a segment that was cut off: what can be read of it is written anew, and takes its place."""

from collections import Counter
from pathlib import Path

from ods.recording.errors import RecordingError
from ods.recording.mcap.reader import ODS, Recorded, open_recording
from ods.recording.mcap.segment import Logged, Segment
from ods.recording.mcap.session import CHUNK_BYTES
from ods.recording.mcap.topics import MESSAGES


def rewrite(path: Path) -> tuple[int, "Counter[str]"]:
    """Complete one segment; return the messages in it and what was lost. Raises RecordingError, OSError."""
    recording = open_recording(path)
    if ODS not in recording.metadata:
        raise RecordingError(f"{path}: does not tell its time: nothing to be saved")
    part = path.with_name(f"{path.name}.new")
    part.unlink(missing_ok=True)
    segment = Segment(part, int(recording.metadata[ODS]["utc_offset_ns"]), recording.metadata)
    try:
        for name, data in recording.attachments.items():
            segment.enclose(name, "application/octet-stream", data, 0)
        count = sum(_written(segment, each, recording.losses) for each in recording.messages())
        segment.finish()
    except BaseException:
        segment.close()
        part.unlink(missing_ok=True)
        raise
    part.replace(path)
    return count, recording.losses


def _written(segment: Segment, message: Recorded, losses: "Counter[str]") -> bool:
    if message.topic not in MESSAGES:
        losses["unknown_channels"] += 1
        return False
    segment.write([Logged(message.topic, message.utc_ns, message.data)])
    if message.topic == "ping" or segment.waiting_bytes >= CHUNK_BYTES:
        segment.close_chunk()
    return True
