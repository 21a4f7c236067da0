"""More than there should be: the tracker process goes on, with valid lists in time, and counts what it leaves out."""

import math
import subprocess
import sys
import time

import pytest

from tests.tracker.played import played

pytestmark = pytest.mark.slow

FLOOD = """
import sys
from pathlib import Path

import zmq

from ods.base import clock
from ods.messages import Pose
from ods.runtime.bus import Publisher

publisher, zeros = Publisher(zmq.Context(), Path(sys.argv[1]), "nav"), (0.0, 0.0, 0.0)
print(flush=True)
while True:
    now = clock.monotonic_ns()
    publisher.publish("pose", Pose(0, now, now, (0.0, 0.0, 4.0), (1.0, 0.0, 0.0, 0.0), zeros, zeros, zeros))
"""


def test_more_objects_than_are_listed() -> None:
    """The nearest are; how many more there are is in the list and in the tracker's health."""
    with played({"planner": {"most_listed": 3}}) as chain:
        chain.echoes = [(20.0 + 15.0 * k, 0.05 * k) for k in range(5)]
        message = chain.until(lambda m: m.valid and m.left_out == 2)
        assert [round(math.hypot(*o.position_ned[:2])) for o in message.obstacles] == [20, 35, 50]
        chain.until(lambda _: bool(chain.health and chain.health.problems))
        assert chain.health is not None
        assert chain.health.problems == ["2 objects are not listed: 3 nearer ones fill the list"]


def test_a_flood_of_poses_leaves_the_lists_valid() -> None:
    """As many poses a second as a process can publish: tens of thousands."""
    with played() as chain:
        chain.until(lambda m: m.valid and len(m.obstacles) == 2)
        chain.poses = False
        chain._publishers.pop("nav").close()
        chain.alive.remove("nav")
        with subprocess.Popen([sys.executable, "-c", FLOOD, str(chain.folder)], stdout=subprocess.PIPE) as flood:
            assert flood.stdout is not None
            flood.stdout.readline()
            begun, first = time.monotonic(), len(chain.lists)
            chain.until(lambda _: time.monotonic() > begun + 3.0)
            flood.kill()
        lists = [m for m in chain.lists[first:] if m.ping_number >= 0]
        wrong = [m.reasons for m in lists if any("pose" in reason for reason in m.reasons)]
        print(f"{len(lists)} lists, {len(wrong)} without a pose")
        assert len(wrong) <= max(5, len(lists) // 5)  # until the flood is received
        assert chain.health is not None
        assert chain.health.counters["pose_thinned"] > 10_000
