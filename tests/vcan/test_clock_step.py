"""The computer's clock steps by an hour, forth and back: by nav, tracker and recorder as processes in a guest kernel.

Only where the clock is the guest's own (see conftest.py). The guest's kernel is not synchronized; the INS knows UTC,
until it says that it does not. CAN frames are stamped by the clock that steps.
"""

import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
import zmq

from ods.base import clock
from ods.base.clock import MS, NS
from ods.messages import Detection, Detections, Health, ObstacleList
from ods.runtime import bus
from ods.sim_sonar.ins.canopen_ins import STATUS_ALL_VALID, SimulatedIns
from ods.tracker.map.store import open_map
from tests.sonar_link import s7k_tables
from tests.tracker.samples import SECTOR

CONFIG = Path(__file__).parents[2] / "config"
PATIENCE_S = 120.0
TIME_NOT_VALID = STATUS_ALL_VALID & ~0b1000
HOUR_NS = 3600 * NS


class Chain:
    """nav, tracker and recorder; INS, pipeline and sonar played by this test; and the planner."""

    def __init__(self, folder: Path, channel: str) -> None:
        self.recording, self.map = folder / "recorded.s7k", folder / ".local/state/ods/map.sqlite"
        self.lists: list[ObstacleList] = []
        for file in CONFIG.glob("*.eds"):
            shutil.copy(file, folder)
        text = (CONFIG / "onboard.toml").read_text().replace("[bus]", f'[bus]\nrun_dir = "{folder}/run"')
        config = folder / "onboard.toml"
        config.write_text(text.replace("~/", f"{folder}/").replace("can0", channel))
        self._true_ahead_ns = clock.utc_offset_ns()
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._publishers = {name: bus.Publisher(self._context, folder / "run", name) for name in ("sonar", "pipeline")}
        self._subscriber = bus.Subscriber(self._context, folder / "run", ["obstacles"])
        self._bus = can.Bus(channel, "socketcan", ignore_config=True)
        self.ins = SimulatedIns(self._bus, CONFIG / "ins.eds")
        self._pings = 0
        commands = ["nav"], ["tracker"], ["record", "--s7k", str(self.recording)]
        self.processes = [
            subprocess.Popen([sys.executable, "-m", "ods", *command, "--config", str(config)]) for command in commands
        ]
        self._done = threading.Event()
        self._sailing = threading.Thread(target=self._sail)
        self._sailing.start()

    def _sail(self) -> None:
        while not self._done.wait(0.05):
            self.ins.send(self.true_utc_ns() // MS * MS, (0.0, 0.0, 4.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))

    def true_utc_ns(self) -> int:
        """Return UTC as the INS knows it."""
        return clock.monotonic_ns() + self._true_ahead_ns

    def step(self, ahead_of_truth_ns: int) -> None:
        """Set the computer's clock."""
        time.clock_settime_ns(time.CLOCK_REALTIME, self.true_utc_ns() + ahead_of_truth_ns)

    def play(self, seconds: float) -> list[ObstacleList]:
        """Send pings with an echo, and signs of life, for so long; return the lists that came."""
        since = len(self.lists)
        until_s = time.monotonic() + seconds
        while time.monotonic() < until_s:
            self._ping(clock.monotonic_ns() - 200 * MS)
            received, _ = self._subscriber.receive(0.0)
            self.lists += [message for _, message in received]
            time.sleep(0.15)
        return self.lists[since:]

    def _ping(self, t_ns: int) -> None:
        echo = Detection(40.0, 0.0, 1.0, 5.0, 3.0, 14.0, 20, 2.0, 0.05, 0.1, 0.01, 0.3)
        stamps = t_ns, t_ns + 150 * MS, clock.utc_ns(t_ns)
        found = Detections(self._pings, self._pings, *stamps, 1480.0, SECTOR, [echo])
        self._publishers["pipeline"].publish("detections", found)
        self._pings += 1
        for name, publisher in self._publishers.items():
            now = clock.monotonic_ns()
            publisher.publish("health", Health(name, 1, 0, now, 0, True, [], {}, {}, {}, {}, 0.0, 0.0))

    def end(self) -> None:
        """Stop the processes as at the end of a mission."""
        for process in self.processes:
            process.terminate()
        assert [process.wait(30.0) for process in self.processes] == [0, 0, 0]

    def close(self) -> None:
        self.step(0)
        self._done.set()
        self._sailing.join()
        for process in self.processes:
            process.kill()
            process.wait()
        self._bus.shutdown()
        for publisher in self._publishers.values():
            publisher.close()
        self._subscriber.close()
        self._context.term()


@pytest.fixture
def chain(vcan0: str, tmp_path: Path) -> Iterator[Chain]:
    made = Chain(tmp_path, vcan0)
    yield made
    made.close()


@pytest.mark.timeout(300)
def test_a_step_of_the_clock_costs_no_list_no_age_and_no_order_in_time(chain: Chain) -> None:
    deadline_s = time.monotonic() + PATIENCE_S
    while not chain.lists or not chain.lists[-1].valid:
        assert time.monotonic() < deadline_s, [message.reasons for message in chain.lists[-1:]]
        chain.play(1.0)
    began_ns = chain.true_utc_ns()
    for ahead_ns in (HOUR_NS, -HOUR_NS, -chain.true_utc_ns() + 1000 * NS):  # the last one: January 1970
        chain.step(ahead_ns)
        lists = chain.play(3.0)
        assert len(lists) > 5
        assert {tuple(message.reasons) for message in lists} == {()}
        assert {message.utc_source for message in lists} == {"ins"}
        assert all(began_ns - NS < message.utc_ns < chain.true_utc_ns() for message in lists)

    chain.ins.status = TIME_NOT_VALID  # from here on UTC is the computer's: 1970
    chain.play(1.0)
    lists = chain.play(2.0)
    assert all(message.valid and message.utc_source == "unsure" for message in lists)
    (obstacle,) = lists[-1].obstacles
    assert lists[-1].utc_ns < 2000 * NS
    assert obstacle.last_seen_utc_ns == pytest.approx(lists[-1].utc_ns, abs=NS)
    assert 11 * NS < lists[-1].utc_ns - obstacle.first_seen_utc_ns < 300 * NS

    chain.ins.status = STATUS_ALL_VALID
    chain.play(2.0)
    ended_ns = chain.true_utc_ns()
    chain.end()
    store = open_map(chain.map, 57.0480, 9.9187)
    (known,) = store.load()
    store.close()
    assert began_ns - 300 * NS < known.first_seen_utc_ns < began_ns
    assert ended_ns - 5 * NS < known.last_seen_utc_ns <= known.hibernated_utc_ns < chain.true_utc_ns()
    recorded = s7k_tables.read(chain.recording)[1:-1]
    for kind in (1003, 3001):  # position, contact
        times = [s7k_tables.instant(record.frame["time"]) for record in recorded if record.type == kind]
        assert len(times) > 30
        assert times == sorted(times)
        assert (times[-1] - times[0]).total_seconds() < 300.0
