"""A chain too slow for every ping: pipeline and tracker as processes, a stage that sleeps, a recorder beside them.

Counts of pings stand for time: what is wanted is that the list is of a ping that was new when the work on it began.
"""

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
import pytest
import zmq

from ods.base import clock
from ods.messages import Health, ObstacleList, Pose
from ods.runtime import bus
from ods.sonar_link.files.opening import open_pings
from tests.pipeline.pings import make_ping

CONFIG = Path(__file__).parents[2] / "config"
STAGE = """
import time
import numpy as np
from ods.base.settings import Positive, Settings
from ods.pipeline.stage.registry import image_stage

class Nap(Settings, frozen=True):
    seconds: Positive = 0.3

@image_stage("slow.nap", Nap)
def nap(params, fan):
    def step(source, out):
        time.sleep(params.seconds)
        np.copyto(out, source)
    return step
"""
PATIENCE_S = 60.0
PERIOD_S, NAP_S = 0.1, 0.3
WAITING = 2 * round(NAP_S / PERIOD_S)
"""Pings that come while one is processed and the next one after it."""
SLACK = 6
"""Pings that may come while a loaded machine does the rest. Eight that wait, as there were once, would be 24."""
LEARNING = 8 * round(NAP_S / PERIOD_S)
"""Pings that come while the detector learns, at the first one, from speckle that goes through the same slow stage."""


class Slow:
    """The processes, a sonar and an INS played by this test, and a planner."""

    def __init__(self, folder: Path) -> None:
        self.run_dir, self.recording = folder / "run", folder / "recorded.s7k"
        self.arrived: list[tuple[int, ObstacleList]] = []
        """With the number of the newest ping sent by then."""
        self.health: dict[str, Health] = {}
        self.sent = 0
        self._poses = 0
        config = self._configuration(folder)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._publishers = {name: bus.Publisher(self._context, self.run_dir, name) for name in ("sonar", "nav")}
        self._subscriber = bus.Subscriber(self._context, self.run_dir, ["obstacles"], ["pipeline", "tracker"])
        commands = ["pipeline"], ["tracker"], ["record", "--s7k", str(self.recording)]
        self.processes = [
            subprocess.Popen([sys.executable, "-m", "ods", *command, "--config", str(config)]) for command in commands
        ]
        amplitude = np.random.default_rng(0).rayleigh(20.0, (60, 1000)) + 1.0
        amplitude[20:24, 500:540] += 200.0
        self._ping = make_ping((40.0 * np.log10(amplitude)).astype(np.uint8), scale="log8", scale_factor=40.0)

    def _configuration(self, folder: Path) -> Path:
        (folder / "slow.py").write_text(STAGE)
        for file in CONFIG.glob("*.eds"):
            shutil.copy(file, folder)
        text = (CONFIG / "onboard.toml").read_text().replace("[bus]", f'[bus]\nrun_dir = "{self.run_dir}"')
        text = text.replace("~/", f"{folder}/").replace("[pipeline]", '[pipeline]\nplugins = ["slow.py"]')
        stages = ("equalize.mean_range", "slow.nap", "filter.fir", "detect.two_level")
        text += "".join(f'\n[[pipeline.stage]]\nuse = "{name}"\n' for name in stages)
        config = folder / "onboard.toml"
        config.write_text(text.replace('use = "slow.nap"', f'use = "slow.nap"\nseconds = {NAP_S}'))
        return config

    def ping_period(self, sends: bool = True) -> None:
        """Send a ping, and poses and signs of life as long as the next one is not due."""
        due_s = time.monotonic() + PERIOD_S
        now = clock.monotonic_ns()
        if sends:
            stamps = {"t_ns": now, "t_rx_ns": now, "utc_ns": clock.utc_ns(now)}
            numbers = {"seq": self.sent, "ping_number": 100 + self.sent}
            self._publishers["sonar"].publish("ping", msgspec.structs.replace(self._ping, **numbers, **stamps))
            self.sent += 1
        for name, publisher in self._publishers.items():
            publisher.publish("health", Health(name, 1, 0, now, 0, True, [], {}, {}, {}, {}, 0.0, 0.0))
        while (left_s := due_s - time.monotonic()) > 0.0:
            now, zeros = clock.monotonic_ns(), (0.0, 0.0, 0.0)
            pose = Pose(self._poses, now, clock.utc_ns(now), zeros, (1.0, *zeros), zeros, zeros, zeros)
            self._publishers["nav"].publish("pose", pose)
            self._poses += 1
            for topic, message in self._subscriber.receive(min(left_s, 0.02))[0]:
                if topic == "obstacles":
                    self.arrived.append((self.sent - 1, message))
                else:
                    self.health[message.process] = message

    def close(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()
        for publisher in self._publishers.values():
            publisher.close()
        self._subscriber.close()
        self._context.term()


@pytest.fixture
def slow() -> Iterator[Slow]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        made = Slow(Path(folder))
        yield made
        made.close()


def test_a_chain_too_slow_for_every_ping_takes_the_newest_and_the_recording_has_them_all(slow: Slow) -> None:
    deadline_s = time.monotonic() + PATIENCE_S
    while len(slow.health) < 2 or not all(health.ready for health in slow.health.values()):
        assert time.monotonic() < deadline_s, slow.health
        slow.ping_period(sends=False)
    for _ in range(80):
        slow.ping_period()
    slow.processes[2].terminate()
    assert slow.processes[2].wait(10.0) == 0

    listed = [(newest, message) for newest, message in slow.arrived if message.ping_number >= 0]
    numbers = [message.ping_number - 100 for _, message in listed]
    behind = [newest - number for (newest, _), number in zip(listed, numbers, strict=True)]
    assert 8 <= len(listed) < 80 / 2
    assert numbers == sorted(set(numbers))
    assert behind[0] <= LEARNING + WAITING + SLACK, behind
    assert max(behind[1:]) <= WAITING + SLACK, behind
    settled = [message for _, message in listed if message.ping_number - 100 > 30]
    assert all(message.valid for message in settled), [message.reasons for message in settled]
    assert [o.state for o in settled[-1].obstacles] == ["active"]
    counters = slow.health["pipeline"].counters
    left_out = counters["skipped_pings"] + counters.get("dropped_ping", 0)  # by itself, or by its queue as it learned
    assert left_out >= 80 - len(listed) - WAITING - SLACK
    assert [ping.ping_number for ping in open_pings(slow.recording).pings] == list(range(100, 180))
