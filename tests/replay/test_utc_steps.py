"""A recorded mission whose UTC was stepped: the same stamps come again, to the nanosecond."""

from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest

from ods.base.clock import NS
from ods.config import part_of
from ods.messages import Detections, Health, ObstacleList, Pose
from ods.pose.utc import VehicleUtc
from ods.recording.mcap.reader import Recorded, open_recording
from ods.recording.mcap.segment import Logged, Segment
from ods.replay.check import check
from ods.replay.setup import recorded_config
from ods.runtime.processes import PROCESSES
from ods.tracker.mission import MissionTracker
from ods.tracker.output.validity import InputMonitor
from ods.tracker.settings import TrackerConfig
from tests.replay.recordings import FOLDER

FIGURE_11 = FOLDER / "figure11.mcap"
STARTED_NS = NS // 2
"""So long before the first message the tracker was started."""
BEGIN_S, STEP_S = 5.0, 9.0
"""Of the recording: there are objects from the first ping on; and when UTC is stepped."""
HOUR_NS = 3600 * NS
YEAR_2026_NS = 1_790_000_000 * NS

Ahead = Callable[[bool], int]
"""How far UTC is ahead of CLOCK_MONOTONIC, before (False) and after the step."""


class Board:
    """The tracker process: takes each message in a round of its own, follows UTC in each, lists what a ping led to."""

    def __init__(self, path: Path, ahead: Ahead) -> None:
        recording = open_recording(path)
        first = next(iter(recording.messages()))
        self._begin_ns, self._step_ns = (first.log_ns + round(s * NS) for s in (BEGIN_S, STEP_S))
        started_ns = self._begin_ns - STARTED_NS
        self._ahead = ahead
        watches = PROCESSES["tracker"].watches
        self.tracker = MissionTracker(
            part_of(recorded_config(recording), TrackerConfig),
            InputMonitor(started_ns, watches, lambda _: ""),
            VehicleUtc(started_ns, ahead(False), "clock"),
        )

    def take(self, recorded: Recorded) -> list[tuple[str, msgspec.Struct]]:
        message = recorded.message()
        if recorded.log_ns < self._begin_ns or message is None:
            return []
        if isinstance(message, Pose):
            message = self._stepped(message)
            self.tracker.hear_pose(message)
        elif isinstance(message, Health):
            self.tracker.hear_health(message)
        self.tracker.follow_utc(recorded.log_ns)
        told = self.tracker.track(message, recorded.log_ns) if isinstance(message, Detections) else None
        lists: list[tuple[str, msgspec.Struct]] = [] if told is None else [("obstacles", told.message)]
        return [(recorded.topic, message), *lists]

    def _stepped(self, pose: Pose) -> Pose:
        """Return a pose with UTC as it was told then, which wobbles by nanoseconds as that of each computer does."""
        wobble_ns = pose.seq * 7919 % 5
        return msgspec.structs.replace(pose, utc_ns=pose.t_ns + self._ahead(pose.t_ns >= self._step_ns) + wobble_ns)


def flown(source: Path, folder: Path, ahead: Ahead) -> tuple[Path, int]:
    """Fly a recorded mission again while UTC is stepped; return the recording of it, and how many steps there were."""
    recording = open_recording(source)
    segment = Segment(folder / "stepped.mcap", int(recording.metadata["ods"]["utc_offset_ns"]), recording.metadata)
    for name, data in recording.attachments.items():
        segment.enclose(name, "", data, 0)
    board = Board(source, ahead)
    for recorded in recording.messages(["ping", "pose", "detections", "health"]):
        for topic, message in board.take(recorded):
            segment.write([Logged(topic, recorded.utc_ns, msgspec.msgpack.encode(message))])
    segment.finish()
    return folder / "stepped.mcap", board.tracker.counters["utc_steps"]


@pytest.mark.parametrize(
    "ahead",
    [
        pytest.param(lambda after: YEAR_2026_NS + after * HOUR_NS, id="forward"),
        pytest.param(lambda after: YEAR_2026_NS - after * HOUR_NS, id="back"),
        pytest.param(lambda after: YEAR_2026_NS if after else 100 * NS, id="from-1970"),
    ],
)
def test_a_mission_whose_utc_was_stepped_comes_again(ahead: Ahead, tmp_path: Path) -> None:
    path, steps = flown(FIGURE_11, tmp_path, ahead)
    assert steps == 1
    lists = [recorded.message() for recorded in open_recording(path).messages(["obstacles"])]
    last = lists[-1]
    assert isinstance(last, ObstacleList)
    assert last.obstacles
    assert {o.first_seen_utc_ns // HOUR_NS for o in last.obstacles} == {last.utc_ns // HOUR_NS}
    result = check(open_recording(path))
    assert result.lists.holds(exactly=True), (result.lists.line(), result.lists.where)
