"""Recorded missions again: what the processes said on the bench comes out of today's code. Regression tests.

Within the tolerances of another computer: to the byte it is right after they were made, until a kernel changes. Where
they differ on purpose: `python -m tests.replay.recordings` makes the recordings anew.
"""

from collections import Counter
from pathlib import Path
from typing import Any

import msgspec
import pytest
import tomli_w

from ods.cli import main
from ods.config import OnboardConfig
from ods.messages import Detections, ObstacleList, Ping, Vector3
from ods.recording.facts import facts
from ods.recording.mcap.reader import Recorded, Recording, open_recording
from ods.recording.mcap.segment import Logged, Segment
from ods.replay.check import check
from ods.replay.compare import Verdict, compare_detections, compare_lists
from ods.replay.machine import differences
from ods.replay.rerun import DetectionsPair, ListPair
from ods.replay.setup import recorded_config
from tests.replay.recordings import FOLDER

FIGURE_11, FAULTS = FOLDER / "figure11.mcap", FOLDER / "faults.mcap"


def changed(source: Path, folder: Path, change: "dict[str, object]") -> Path:
    """Copy a recording; of the topics in `change` a function makes other messages, or none of one."""
    recording = open_recording(source)
    offset_ns = int(recording.metadata["ods"]["utc_offset_ns"])
    segment = Segment(folder / "changed.mcap", offset_ns, recording.metadata)
    for name, data in recording.attachments.items():
        segment.enclose(name, "", data, 0)
    for recorded in recording.messages():
        make = change.get(recorded.topic)
        data = make(recorded) if callable(make) else recorded.data
        if data is not None:
            segment.write([Logged(recorded.topic, recorded.utc_ns, data)])
    segment.finish()
    return folder / "changed.mcap"


def counted(recording: Recording) -> "Counter[str]":
    return Counter(recorded.topic for recorded in recording.messages(["detections", "obstacles"]))


@pytest.mark.parametrize("path", [FIGURE_11, FAULTS], ids=lambda path: path.stem)
def test_what_was_recorded_comes_again(path: Path) -> None:
    recording = open_recording(path)
    result = check(recording)
    held = result.detections.holds(exactly=False) and result.lists.holds(exactly=False)
    assert held, (result.detections.line(), result.lists.line(), result.lists.where, result.counters)
    wanted = counted(recording)
    assert (result.detections.counts.total(), result.lists.counts.total()) == (
        wanted["detections"],
        wanted["obstacles"],
    )
    assert {o.state for o in lists_of(path)[-1].obstacles} >= {"active"}


def lists_of(path: Path) -> list[ObstacleList]:
    messages = [recorded.message() for recorded in open_recording(path).messages(["obstacles"])]
    return [message for message in messages if isinstance(message, ObstacleList)]


def test_restarts_are_followed() -> None:
    """The pipeline, the tracker and the nav process were killed, each once."""
    counters = check(open_recording(FAULTS)).counters
    assert (counters["pipeline_restarts"], counters["tracker_restarts"], counters["tracker_anew"]) == (1, 1, 0)


def test_a_changed_list_is_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    numbers = []

    def radius(recorded: Recorded) -> bytes:
        message = recorded.message()
        assert isinstance(message, ObstacleList)
        if message.ping_number != 60:
            return recorded.data
        first = msgspec.structs.replace(message.obstacles[0], radius_m=message.obstacles[0].radius_m + 1.0)
        numbers.append(message.seq)
        return msgspec.msgpack.encode(msgspec.structs.replace(message, obstacles=[first, *message.obstacles[1:]]))

    path = changed(FIGURE_11, tmp_path, {"obstacles": radius})
    result = check(open_recording(path))
    assert result.lists.counts[Verdict.OTHER] == 1
    assert len(numbers) == 1
    if not result.other:
        assert main(["replay", str(path), "--check"]) == 1
        assert "NOT as recorded" in capsys.readouterr().out


@pytest.mark.parametrize(("change", "verdict"), [(1e-15, Verdict.ROUNDED), (1e-6, Verdict.NEAR), (1e-2, Verdict.OTHER)])
def test_last_digits_may_differ_and_no_more(change: float, verdict: Verdict) -> None:
    """Another compiler's order of the same sums is no other result; a millionth of a range is one."""
    reported = max(lists_of(FIGURE_11), key=lambda message: len(message.obstacles))
    moved = [msgspec.structs.replace(o, position_ned=_times(o.position_ned, 1.0 + change)) for o in reported.obstacles]
    again = msgspec.structs.replace(reported, obstacles=moved)
    assert compare_lists(ListPair(reported, msgspec.msgpack.encode(reported), again)).verdict is verdict

    pings = (recorded.message() for recorded in open_recording(FIGURE_11).messages(["detections"]))
    received = next(message for message in pings if isinstance(message, Detections) and message.detections)
    ranges = [msgspec.structs.replace(d, range_m=d.range_m * (1.0 + change)) for d in received.detections]
    nudged = msgspec.structs.replace(received, detections=ranges)
    assert compare_detections(DetectionsPair(0, received, msgspec.msgpack.encode(received), nudged)).verdict is verdict


def _times(position: Vector3, factor: float) -> Vector3:
    x, y, z = position
    return x * factor, y * factor, z * factor


def test_pings_that_the_recorder_missed_are_counted(tmp_path: Path) -> None:
    def every_tenth_lost(recorded: Recorded) -> bytes | None:
        message = recorded.message()
        assert isinstance(message, Ping)
        return None if message.ping_number % 10 == 9 else recorded.data

    result = check(open_recording(changed(FIGURE_11, tmp_path, {"ping": every_tenth_lost})))
    assert result.counters["missing_pings"] == result.detections.counts[Verdict.NONE] > 5
    assert result.lists.counts[Verdict.NONE] == 0  # they rest on the detections that were recorded


def test_poses_heard_later_by_the_recorder_change_nothing(tmp_path: Path) -> None:
    """`poses_until` tells what was known; without it 10 ms would change most lists (issue 15)."""
    recording = open_recording(FIGURE_11)
    offset_ns = int(recording.metadata["ods"]["utc_offset_ns"])
    segment = Segment(tmp_path / "late.mcap", offset_ns, recording.metadata)
    for name, data in recording.attachments.items():
        segment.enclose(name, "", data, 0)
    late = [
        recorded._replace(utc_ns=recorded.utc_ns + (20_000_000 if recorded.topic == "pose" else 0))
        for recorded in recording.messages()
    ]
    for recorded in sorted(late, key=lambda each: each.utc_ns):
        segment.write([Logged(recorded.topic, recorded.utc_ns, recorded.data)])
    segment.finish()
    assert check(open_recording(tmp_path / "late.mcap")).lists.counts == check(recording).lists.counts


def test_another_configuration_lists_the_differences(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = recorded_config(open_recording(FIGURE_11))
    plain = msgspec.to_builtins(config, enc_hook=str)
    plain["tracker"]["life"]["confirm_echoes"] = 6
    other = tmp_path / "other.toml"
    other.write_text(tomli_w.dumps(without_none(plain)))
    assert main(["replay", str(FIGURE_11), "--check", "--config", str(other)]) == 0
    said = capsys.readouterr().out
    assert "3 objects of both" in said
    rows = [[cell.strip() for cell in line.split("│")[1:5]] for line in said.splitlines() if line.startswith("│")]
    both = [(float(before), float(now)) for _, number, before, now in rows if number != "-"]
    assert len(both) == 3
    assert all(now > before + 0.3 for before, now in both)  # three echoes more


def without_none(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: without_none(item) for key, item in value.items() if item is not None}
    return [without_none(item) for item in value] if isinstance(value, list) else value


def test_another_computer_is_reported() -> None:
    here = facts("")
    assert differences(here, here) == []
    other = here | {"cpu": "Other", "cpu_flags": "none", "numpy": "1.0"}
    assert differences(other, here) == [
        f"another type of CPU: Other, here {here['cpu']}",
        f"another numpy: 1.0, here {here['numpy']}",
    ]


def test_no_recording_and_none_with_a_configuration_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Segment(tmp_path / "bare.mcap", 0, {"ods": {"utc_offset_ns": "0"}}).finish()
    for path, said, code in (("absent", "No such file", 1), ("bare.mcap", "no configuration", 2)):
        assert main(["replay", str(tmp_path / path), "--check"]) == code
        reported = capsys.readouterr().err
        assert said in reported
        assert reported.count("\n") == 1
    assert isinstance(recorded_config(open_recording(FIGURE_11)), OnboardConfig)
