"""What is received of a vehicle, over a real bus on which the test publishes."""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import msgspec
import pytest
import zmq

from ods.base import clock
from ods.base.clock import MS, NS
from ods.messages import Health, ObstacleList, Pose
from ods.runtime import bus
from ods.workbench.engine.live import Live, state_of
from tests.export import mission

HEALTH = Health("tracker", 7, 0, 0, 0, True, [], {}, {}, {}, {}, 1.0, 50.0)
replace = msgspec.structs.replace


class Vehicle:
    """Processes that publish what they are reported to."""

    def __init__(self, run_dir: Path, stack: ExitStack, *others: str) -> None:
        context = stack.enter_context(zmq.Context())
        names = ("sonar", "nav", "pipeline", "tracker", *others)
        self._publishers = {name: bus.Publisher(context, run_dir, name) for name in names}
        for publisher in self._publishers.values():
            stack.callback(publisher.close)

    def say(self, topic: str, message: msgspec.Struct) -> None:
        self._publishers[bus.TOPICS[topic].publisher].publish(topic, message)

    def report(self, health: Health) -> None:
        self._publishers[health.process].publish(bus.HEALTH, replace(health, t_ns=clock.monotonic_ns()))

    def tell(self, **changes: object) -> ObstacleList:
        """Publish a list of a ping of 100 ms ago, read 40 ms ago."""
        now_ns = clock.monotonic_ns()
        reported = replace(mission.LIST, t_ns=now_ns - 100 * MS, t_rx_ns=now_ns - 40 * MS, **changes)
        self.say("obstacles", reported)
        return reported


@pytest.fixture
def vehicle(tmp_path: Path) -> Iterator[Vehicle]:
    with ExitStack() as stack:
        yield Vehicle(tmp_path, stack)


@pytest.fixture
def live(tmp_path: Path, vehicle: Vehicle) -> Iterator[Live]:
    made = Live(tmp_path)
    time.sleep(0.3)  # until the sockets have found each other
    yield made
    made.close()


def until(met: Callable[[], object]) -> None:
    deadline = time.monotonic() + 10.0
    while not met():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_the_newest_of_everything_is_known(vehicle: Vehicle, live: Live) -> None:
    vehicle.say("ping", mission.PING)
    vehicle.say("pose", mission.POSE)
    vehicle.say("detections", mission.DETECTIONS)
    reported = vehicle.tell(valid=True, reasons=[])
    until(lambda: live.ping and live.pose and live.detections and live.obstacles)
    assert live.ping == mission.PING
    assert live.pose == mission.POSE
    assert live.detections == mission.DETECTIONS
    assert live.obstacles == reported
    assert list(live.path) == [mission.POSE.position_ned[:2]]


def test_reasons_of_a_list_that_is_not_valid_are_reported(vehicle: Vehicle, live: Live) -> None:
    vehicle.tell(valid=False, reasons=["no pose for 0.8 s", "nav: CAN bus off"])
    until(lambda: live.obstacles)
    verdict = live.verdict(clock.monotonic_ns())
    assert not verdict.valid
    assert verdict.reasons == ("no pose for 0.8 s", "nav: CAN bus off")


def test_a_valid_list_is_valid_until_the_tracker_is_silent(vehicle: Vehicle, live: Live) -> None:
    vehicle.tell(valid=True, reasons=[])
    until(lambda: live.obstacles)
    now_ns = clock.monotonic_ns()
    assert live.verdict(now_ns).valid
    later = live.verdict(now_ns + 3 * NS)
    assert not later.valid
    assert later.reasons[0].startswith("no obstacle list for 3.")


def test_silence_is_said_in_words(vehicle: Vehicle, live: Live) -> None:
    assert any(text.startswith("no pings yet") for text in live.silences(clock.monotonic_ns()))
    vehicle.say("ping", mission.PING)
    until(lambda: live.ping)
    now_ns = clock.monotonic_ns()
    assert not any("pings" in text for text in live.silences(now_ns))
    assert live.silences(now_ns + 3 * NS)[0].startswith("no pings for 3.")


def test_a_sonar_that_pings_seldom_is_not_said_to_be_silent(vehicle: Vehicle, live: Live) -> None:
    vehicle.say("ping", mission.PING)
    until(lambda: live.ping)
    time.sleep(0.5)
    first = live.ping
    vehicle.say("ping", mission.PING)
    until(lambda: live.ping is not first)
    now_ns = clock.monotonic_ns()
    age_s = live.age_s("ping", now_ns)
    assert age_s is not None
    received_ns = now_ns - round(age_s * NS)
    assert not any("pings" in text for text in live.silences(received_ns + NS * 13 // 10))
    assert live.silences(received_ns + NS * 31 // 10)[0].startswith("no pings for 3.")


def test_a_run_dir_of_nobody_says_what_is_missing(tmp_path: Path) -> None:
    alone = Live(tmp_path / "none")
    verdict = alone.verdict(clock.monotonic_ns())
    alone.close()
    assert not verdict.valid
    assert "no socket of the tracker" in verdict.reasons[0]


def test_the_log_tells_changes_once(vehicle: Vehicle, live: Live) -> None:
    vehicle.tell(valid=False, reasons=["no pose for 0.8 s"])
    until(lambda: any("no pose for 0.8 s" in line.text for line in live.log))
    vehicle.tell(valid=False, reasons=["no pose for 1.1 s"])  # the same, a little later
    vehicle.report(replace(HEALTH, counters={"echoes_bad": 1}))
    until(lambda: "tracker" in live.health)
    vehicle.report(replace(HEALTH, counters={"echoes_bad": 4}, seq=1))
    until(lambda: any("echoes_bad" in line.text for line in live.log))
    vehicle.tell(valid=True, reasons=[])
    until(lambda: any(line.text == "the list is valid" for line in live.log))
    texts = [line.text for line in live.log]
    assert sum("no pose for" in text for text in texts) == 1
    assert "tracker: echoes_bad 3 more, 4 in all" in texts
    assert [line.bad for line in live.log if "list is valid" in line.text] == [False]


def test_latency_counts_from_ping_and_from_its_last_byte(vehicle: Vehicle, live: Live) -> None:
    vehicle.tell(valid=True, reasons=[])
    until(lambda: live.obstacles)
    latency = live.latency(clock.monotonic_ns())
    assert latency.whole_ms[0] - latency.own_ms[0] == pytest.approx(60.0)
    assert 40.0 <= latency.own_ms[0] < 5000.0


def test_listeners_hear_of_each_topic_and_of_time(vehicle: Vehicle, live: Live) -> None:
    received: list[str] = []
    stop = live.listen(received.append)
    vehicle.say("ping", mission.PING)
    until(lambda: "ping" in received and "" in received)
    stop()
    count = len(received)
    time.sleep(0.4)
    assert len(received) == count


def test_nothing_is_published_or_requested(tmp_path: Path, vehicle: Vehicle, live: Live) -> None:
    """Only the sockets and locks of the vehicle are there; a listener binds none."""
    until(lambda: "tracker" in str(sorted(tmp_path.iterdir())))
    names = {path.name.partition(".")[0] for path in tmp_path.iterdir()}
    assert names == {"sonar", "nav", "pipeline", "tracker"}


@pytest.mark.parametrize(
    ("health", "age_s", "state"),
    [
        (None, None, ("not heard of", True)),
        (HEALTH, 0.4, ("ready", False)),
        (HEALTH, 3.4, ("silent for 3 s", True)),
        (replace(HEALTH, problems=["disk full", "no line"]), 0.1, ("disk full; no line", True)),
        (replace(HEALTH, ready=False), 0.1, ("starting", True)),
    ],
)
def test_states_of_processes_in_words(health: Health | None, age_s: float | None, state: tuple[str, bool]) -> None:
    assert state_of(health, age_s) == state


def test_the_way_is_kept_sparsely(vehicle: Vehicle, live: Live) -> None:
    for north in range(20):
        vehicle.say("pose", replace(mission.POSE, seq=north, position_ned=(float(north), 0.0, 0.0)))
    until(lambda: isinstance(live.pose, Pose) and live.pose.seq == 19)
    assert len(live.path) <= 2
