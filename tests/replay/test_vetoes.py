"""A recorded mission with an operator's orders: with them the same lists come again, without them others."""

from pathlib import Path

import msgspec

from ods.messages import ObstacleList, VetoOrder, VetoRegion, VetoRequest
from ods.recording.mcap.reader import open_recording
from ods.recording.mcap.segment import Logged, Segment
from ods.replay.check import check
from tests.replay.test_utc_steps import FIGURE_11, YEAR_2026_NS, Board

EVERYWHERE = VetoRegion(centre_ne=(0.0, 0.0), radius_m=100.0)
REQUESTS = {
    20: VetoRequest(do="ignore", region=EVERYWHERE, reason="all that rests", for_s=60.0),
    40: VetoRequest(do="forget", id=1, reason="a ghost"),
}
"""By the number of the list after which they are carried out."""


def flown(folder: Path, *, recorded_too: bool) -> tuple[Path, list[ObstacleList]]:
    recording = open_recording(FIGURE_11)
    segment = Segment(folder / "vetoed.mcap", int(recording.metadata["ods"]["utc_offset_ns"]), recording.metadata)
    for name, data in recording.attachments.items():
        segment.enclose(name, "", data, 0)
    board = Board(FIGURE_11, lambda _: YEAR_2026_NS)
    lists: list[ObstacleList] = []
    for recorded in recording.messages(["ping", "pose", "detections", "health"]):
        for topic, message in board.take(recorded):
            segment.write([Logged(topic, recorded.utc_ns, msgspec.msgpack.encode(message))])
            if not isinstance(message, ObstacleList):
                continue
            lists.append(message)
            request = REQUESTS.get(len(lists))
            if request is None:
                continue
            t_ns = message.made_ns + 1
            board.tracker.follow(request, "anna", t_ns)
            order = VetoOrder(seq=len(lists), t_ns=t_ns, utc_ns=0, author="anna", request=request, refused="")
            if recorded_too:
                segment.write([Logged("veto-orders", recorded.utc_ns, msgspec.msgpack.encode(order))])
    segment.finish()
    return folder / "vetoed.mcap", lists


def test_orders_are_carried_out_again(tmp_path: Path) -> None:
    path, lists = flown(tmp_path, recorded_too=True)
    assert any(each.ignored_by >= 0 for each in lists[21].obstacles)
    assert {each.id: each.state for each in lists[40].obstacles}[1] == "terminated"
    result = check(open_recording(path))
    assert result.lists.holds(exactly=True), (result.lists.line(), result.lists.where)


def test_without_its_orders_a_mission_is_another(tmp_path: Path) -> None:
    path, _ = flown(tmp_path, recorded_too=False)
    assert not check(open_recording(path)).lists.holds(exactly=True)
