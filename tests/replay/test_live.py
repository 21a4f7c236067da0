"""A live replay: when it publishes what, what it does as asked, and what a planner gets of it over real sockets."""

import threading
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
import zmq
from hypothesis import HealthCheck, given, settings, strategies as st

from ods.base import clock
from ods.client import Obstacles, Replay, ReplayError
from ods.messages import ObstacleList, ReplayRequest
from ods.recording.mcap.reader import Recorded, open_recording
from ods.recording.mcap.topics import decoded
from ods.replay import live, player
from ods.replay.live import Wanted
from ods.replay.player import Player
from ods.replay.timeline import Timeline
from ods.runtime import bus
from ods.runtime.run_dir import RunDirError
from tests.export import mission
from tests.export.mission import T_NS, UTC_NS
from tests.recording.mcap_samples import mission as long_mission, write_segment

TOPIC_OF = {"Ping": "ping", "Pose": "pose", "Detections": "detections", "ObstacleList": "obstacles", "Health": "health"}
PERIOD_NS = 20_000_000


def recorded(message: msgspec.Struct, after_ns: int) -> Recorded:
    """Return a message as recorded `after_ns` after T_NS, its times moved on likewise."""
    later = msgspec.structs.replace(message, t_ns=T_NS + after_ns)
    topic = TOPIC_OF[type(message).__name__]
    return Recorded(topic, T_NS + after_ns, UTC_NS + after_ns, msgspec.msgpack.encode(later))


def mission_of(cycles: int) -> list[Recorded]:
    """Return so many pose, ping, list."""
    parts = (mission.POSE, mission.PING, mission.LIST)
    return [recorded(part, n * PERIOD_NS) for n in range(cycles) for part in parts]


class Bench:
    """A player whose clock is the real one, and what it published."""

    def __init__(self, speed: float = 1.0) -> None:
        self.out: list[tuple[str, Any, int]] = []
        self.asked: list[ReplayRequest] = []
        self.answers: list[Any] = []
        self.lines: list[str] = []
        self.player = Player(Timeline(speed, 0), self._publish, self, self.lines.append)

    def _publish(self, process: str, topic: str, message: msgspec.Struct) -> None:
        self.out.append((topic, message, clock.monotonic_ns()))

    def receive(self) -> list[tuple[list[bytes], Any]]:
        asked, self.asked = self.asked, []
        return [([b"peer"], request) for request in asked]

    def answer(self, peer: list[bytes], message: msgspec.Struct) -> None:
        self.answers.append(message)

    def play(self, messages: list[Recorded], *processes: str, span_s: tuple[float, float] = (0.0, 1e9)) -> None:
        self.player.play(messages, span_s, frozenset(processes or ("nav", "sonar", "tracker")))

    def topics(self) -> list[str]:
        return [topic for topic, _, _ in self.out]


def test_each_message_is_published_when_it_is_due() -> None:
    bench = Bench()
    bench.play(mission_of(5))
    assert bench.topics() == ["pose", "ping", "obstacles"] * 5
    begin_ns = bench.out[0][1].t_ns
    for number, (_, message, now_ns) in enumerate(bench.out):
        assert message.t_ns - begin_ns == number // 3 * PERIOD_NS  # one offset for all
        assert now_ns >= message.t_ns  # never before it happened
    assert [message.utc_ns - message.t_ns for _, message, _ in bench.out] == [-PERIOD_NS * (n // 3) for n in range(15)]


def test_a_part_of_a_recording_and_of_its_processes() -> None:
    bench = Bench(speed=100.0)
    bench.play(mission_of(20), "sonar", span_s=(0.1, 0.2))
    assert bench.topics() == ["ping"] * 6  # 0.10, 0.12, ... 0.20
    health = [recorded(mission.HEALTH, 0), recorded(msgspec.structs.replace(mission.HEALTH, process="nav"), 0)]
    bench.play(health, "sonar")
    assert [message.process for topic, message, _ in bench.out if topic == "health"] == ["sonar"]


def test_a_pause_a_step_and_going_on() -> None:
    bench = Bench()
    bench.asked = [ReplayRequest(do="step", steps=2)]
    feed = mission_of(4)

    def asking() -> Iterator[Recorded]:
        for number, message in enumerate(feed):
            if number == 6:
                assert bench.player.paused
                bench.asked = [ReplayRequest(), ReplayRequest(do="go", speed=100.0)]
            yield message

    bench.player.play(asking(), (0.0, 1e9), frozenset({"nav", "sonar", "tracker"}))
    assert len(bench.out) == 12
    assert [(answer.paused, answer.published, answer.speed) for answer in bench.answers] == [
        (False, 0, 1.0), (True, 6, 1.0), (False, 6, 100.0),
    ]  # fmt: skip
    assert bench.answers[1].at_s == pytest.approx(0.02)


def test_long_silence_and_another_start_of_the_computer_are_skipped() -> None:
    bench = Bench()
    bench.play([recorded(mission.PING, after_s * 10**9) for after_s in (0, 3600, 100)])
    assert bench.out[-1][2] - bench.out[0][2] < 10**9
    assert [now_ns - message.t_ns < 10**9 for _, message, now_ns in bench.out] == [True] * 3


def test_what_cannot_be_read_is_counted() -> None:
    bench = Bench()
    bench.play([Recorded("ping", T_NS, UTC_NS, b"?"), recorded(mission.PING, 0)])
    assert (bench.player.losses, bench.topics()) == ({"bad_ping": 1}, ["ping"])


@pytest.mark.parametrize("field", ["t_ns", "utc_ns", "t_rx_ns", "first_seen_utc_ns"])
@pytest.mark.parametrize("far_ns", [2**64 - 1, 2**62, -(2**63)])
def test_a_time_that_no_message_can_tell_is_counted(field: str, far_ns: int) -> None:
    bench = Bench()
    if field == "first_seen_utc_ns":
        rock = msgspec.structs.replace(mission.ROCK, first_seen_utc_ns=far_ns)
        far = msgspec.structs.replace(mission.LIST, obstacles=[rock])
    else:
        far = msgspec.structs.replace(mission.LIST, **{field: far_ns})
    lists = [msgspec.msgpack.encode(picture) for picture in (mission.LIST, far, mission.LIST)]
    bench.play([Recorded("obstacles", T_NS, UTC_NS, data) for data in lists])
    assert bench.player.published == 3 - bench.player.losses["bad_obstacles"]
    for _, message, _ in bench.out:
        msgspec.msgpack.decode(msgspec.msgpack.encode(message), type=ObstacleList)


def test_a_planner_sees_the_mission_again_and_may_stop_it(tmp_path: Path) -> None:
    def messages(topics: Collection[str]) -> Iterator[Recorded]:
        return (each for each in mission_of(400) if each.topic in topics)

    planner, asker = Obstacles(tmp_path, stale_s=5.0), Replay(tmp_path, timeout_s=5.0)
    played: list[live.Played] = []
    thread = threading.Thread(target=lambda: played.append(live.play(messages, tmp_path, Wanted())))
    thread.start()
    try:
        first = planner.next()
        assert (first.reasons, first.obstacles[0].id) == (mission.LIST.reasons, 7)
        assert 0 <= clock.monotonic_ns() - first.t_ns < 10**9
        with pytest.raises(RunDirError, match="another `ods replay` already runs"):
            live.play(messages, tmp_path, Wanted())
        paused = asker.pause()
        assert paused.paused
        assert asker.step(3).published == paused.published
        with pytest.raises(ReplayError, match="bad request"):
            asker.ask(ReplayRequest(speed=-1.0))
    finally:
        asker.go(100.0)
        thread.join()
    assert played[0].messages == 1200
    planner.close()
    asker.close()


def test_processes_that_run_are_not_played_over(tmp_path: Path) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = bus.Publisher(context, tmp_path, "tracker")
    try:
        with pytest.raises(RunDirError, match="another `ods tracker` already runs"):
            live.play(lambda _: mission_of(1), tmp_path, Wanted())
        played = live.play(lambda _: mission_of(1)[:2], tmp_path, Wanted(topics=("ping", "pose")))
        assert played.messages == 2
        with pytest.raises(live.ReplayError, match="nothing to replay"):
            live.play(lambda _: [], tmp_path, Wanted(topics=("ping",), loop=True))
    finally:
        publisher.close()
        context.term()


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_of_a_damaged_recording_only_messages_are_published(
    data: st.DataObject, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(player, "LONGEST_GAP_NS", 0)  # nothing is waited for
    if not (tmp_path / "whole.mcap").exists():
        write_segment(tmp_path / "whole.mcap", long_mission(3), finish=False)
    damaged = bytearray((tmp_path / "whole.mcap").read_bytes())
    for place in data.draw(st.lists(st.integers(200, len(damaged) - 1), min_size=1, max_size=8)):
        damaged[place] ^= data.draw(st.integers(1, 255))
    (tmp_path / "a.mcap").write_bytes(damaged)
    bench = Bench()
    bench.play(list(open_recording(tmp_path / "a.mcap").messages([*bus.TOPICS, bus.HEALTH])))
    for topic, message, _ in bench.out:
        sent = msgspec.msgpack.encode(message)
        assert msgspec.msgpack.encode(decoded(topic, sent)) == sent
