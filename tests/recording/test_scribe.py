"""What the recorder takes along at its start, and what it leaves out."""

from pathlib import Path

import pytest

from ods.recording.inbox import Inbox, Received
from ods.recording.mcap.reader import open_recording
from ods.recording.recording_writer import RecordingWriter
from ods.recording.settings import RecordConfig, RecordSettings
from ods.tracker.settings import MapSettings, TrackerSettings
from tests.locked_folder import lock


def test_a_map_that_may_not_be_looked_at_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, path = tmp_path / "recording", tmp_path / "locked" / "map.sqlite"
    lock(monkeypatch, path.parent)
    tracker, inbox = TrackerSettings(map=MapSettings(path=path)), Inbox(1000)
    scribe = RecordingWriter(RecordConfig(RecordSettings(keep_free_mb=0.0), tracker, out=folder), inbox, lambda: True)
    inbox.put([Received("sonar-answers", 1, b"\x80")])
    inbox.close()
    scribe.run()
    assert scribe.problem == ""
    (facts,) = open_recording(folder).metadata.values()
    assert facts["map"] == f"left out: map {path}: permission denied"
