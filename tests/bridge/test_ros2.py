"""The bridge to ROS 2 as a process, and a node of another make as another: loopback only, types written by hand."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from ods.base import clock
from tests.bridge.played import ROOT, Bridge, bridge_of
from tests.bridge.samples import ROCK, SWIMMER

pytest.importorskip("cyclonedds", reason="pip install 'ods[ros2]'")
pytestmark = pytest.mark.slow
ERROR, OK, STALE = 2, 0, 3


class Listener:
    """What another process receives."""

    def __init__(self, command: list[str], env: dict[str, str]) -> None:
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, cwd=ROOT, env=env)
        assert self.process.stdout is not None
        assert json.loads(self.process.stdout.readline()) == {"ready": True}
        os.set_blocking(self.process.stdout.fileno(), False)
        self.received: list[dict[str, Any]] = []

    def of(self, topic: str) -> list[dict[str, Any]]:
        """Return what has come on a topic so far."""
        assert self.process.stdout is not None
        for line in iter(self.process.stdout.readline, b""):
            self.received.append(json.loads(line))
        return [each for each in self.received if each["topic"] == topic]

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()


@contextmanager
def listener(domain: int) -> Iterator[Listener]:
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", "tests.bridge.ros2_listener", str(domain)]
    made = Listener(command, os.environ | {"PYTHONPATH": path})
    try:
        yield made
    finally:
        made.close()


@pytest.fixture
def domain() -> int:
    """Another one for each process of the tests: they must not receive each other."""
    return 100 + os.getpid() % 100


@contextmanager
def running_in(domain: int, keys: str = "") -> Iterator[Bridge]:
    with bridge_of("ros2", f"domain = {domain}\nmost_hz = 100.0\n{keys}") as made:
        yield made


def test_lists_arrive_in_enu_while_they_are_valid_and_silence_follows(domain: int) -> None:
    with running_in(domain) as running, listener(domain) as node:
        running.obstacles = [SWIMMER, ROCK]
        running.until(lambda: len(node.of("obstacles")) > 3 and running.well())
        last = node.of("obstacles")[-1]
        assert last["frame"] == "map"
        assert [each["id"] for each in last["obstacles"]] == [7, 300]  # the nearest first
        assert last["obstacles"][0]["enu"] == [50.0, 100.0, -5.0]
        assert abs(last["stamp_ns"] - clock.utc_ns()) < 5 * clock.NS
        assert node.of("diagnostics")[-1]["level"] == OK
        running.valid = False
        running.until(lambda: running.says("nothing is sent: the list is not valid: the INS is silent"))
        before, withheld = len(node.of("obstacles")), running.counts("withheld_lists")
        running.until(lambda: running.counts("withheld_lists") > withheld + 4)
        assert len(node.of("obstacles")) == before
        reported = node.of("diagnostics")[-1]
        assert (reported["level"], reported["values"]["valid"]) == (ERROR, "False")
        assert "the INS is silent" in reported["message"]
        running.published = False
        running.until(lambda: node.of("diagnostics")[-1]["level"] == STALE)
        running.valid = running.published = True
        running.until(lambda: len(node.of("obstacles")) > before and running.well())


def test_who_comes_later_gets_the_list_that_holds_and_none_that_has_expired(domain: int) -> None:
    with running_in(domain) as running:
        running.obstacles = [ROCK]
        running.until(lambda: running.says(f"no node has subscribed in domain {domain} on lo"))
        assert running.counts("unheard_lists") > 0
        with listener(domain) as first:
            running.until(lambda: bool(first.of("obstacles")) and running.well())
            running.published = False
            running.until(lambda: running.says("nothing is sent: no obstacle list for"))  # which is after 1 s
            with listener(domain) as later:
                running.until(lambda: bool(later.of("diagnostics")))  # it is known, and has got all that is kept
                assert later.of("obstacles") == []
                running.published = True
                running.until(lambda: bool(later.of("obstacles")))


def test_a_node_that_hangs_and_one_that_is_killed_delay_nobody(domain: int) -> None:
    with running_in(domain) as running, listener(domain) as hung, listener(domain) as node:
        running.obstacles = [ROCK]
        running.until(lambda: bool(hung.of("obstacles")) and bool(node.of("obstacles")))
        hung.process.send_signal(signal.SIGSTOP)
        sent, received = running.counts("sent_lists"), len(node.of("obstacles"))
        running.until(lambda: running.counts("sent_lists") > sent + 20)
        assert len(node.of("obstacles")) >= received + 20
        hung.process.kill()
        sent = running.counts("sent_lists")
        running.until(lambda: running.counts("sent_lists") > sent + 5)
        assert running.counts("unsent_messages") == 0


def test_frames_and_images_only_where_they_are_wanted(domain: int) -> None:
    keys = 'send = ["tf", "image"]\nimage_hz = 20.0\nimage_bytes = 4000'
    with running_in(domain, keys) as running, listener(domain) as node:
        running.obstacles, running.pinged = [ROCK], True
        running.until(lambda: bool(node.of("tf")) and bool(node.of("image")))
        assert node.of("tf")[-1]["frames"] == [["map", "base_link"]]
        image = node.of("image")[-1]
        assert (image["frame"], image["beams"], image["dtype"]) == ("sonar_fan", 64, 0)
        assert image["ranges"] * 64 == image["bytes"] <= 4000
        assert node.of("obstacles") == node.of("diagnostics") == []


IN_A_NETWORK_OF_ITS_OWN = ["unshare", "--user", "--map-root-user", "--net"]


def test_an_interface_that_goes_and_comes_is_said_and_used_again(tmp_path: Path) -> None:
    """In a network of its own, whose loopback is down at first."""
    script = tmp_path / "test.py"
    script.write_text(
        "import subprocess\n"
        "from tests.bridge.samples import ROCK\n"
        "from tests.bridge.test_ros2 import listener, running_in\n"
        "with running_in(7) as running:\n"
        "    running.obstacles = [ROCK]\n"
        "    running.until(lambda: running.says('lo: the interface is down'))\n"
        "    assert running.counts('unsent_messages') and running.counts('interface_losses')\n"
        "    subprocess.run(['ip', 'link', 'set', 'lo', 'up'], check=True)\n"
        "    with listener(7) as node:\n"
        "        running.until(lambda: bool(node.of('obstacles')) and running.well())\n"
        "    subprocess.run(['ip', 'link', 'set', 'lo', 'down'], check=True)\n"
        "    running.until(lambda: running.says('lo: the interface is down'))\n"
        "    subprocess.run(['ip', 'link', 'set', 'lo', 'up'], check=True)\n"
        "    with listener(7) as node:\n"
        "        running.until(lambda: bool(node.of('obstacles')) and running.well())\n"
        "print('all seen')\n"
    )
    if subprocess.run([*IN_A_NETWORK_OF_ITS_OWN, "ip", "link"], capture_output=True, check=False).returncode:
        pytest.skip("no network namespaces here, or no `ip`")
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    ran = subprocess.run(
        [*IN_A_NETWORK_OF_ITS_OWN, sys.executable, str(script)], env=os.environ | {"PYTHONPATH": path}, cwd=ROOT,
        capture_output=True, text=True, timeout=200.0, check=False,
    )  # fmt: skip
    assert ran.stdout.endswith("all seen\n"), ran.stdout + ran.stderr
