"""Stock nodes of ROS 2 Jazzy and Kilted receive the bridge: all of it, at 7 lists a second. `make test-peers`."""

import os
import sys
import time
from pathlib import Path

import pytest

from tests.bridge.played import ROOT, bridge_of
from tests.bridge.samples import ROCK, SWIMMER
from tests.bridge.test_ros2 import Listener

pytest.importorskip("cyclonedds", reason="pip install 'ods[ros2]'")
pytestmark = pytest.mark.slow
PEERS = Path(os.environ.get("ODS_PEERS", ROOT / "out" / "peers"))
LISTS, LISTS_HZ = 140, 7
OF_A_LIST = ("/ods/markers", "/ods/clearance", "/ods/odometry")
ERROR = 2


@pytest.mark.parametrize("generation", ["jazzy", "kilted"])
def test_a_stock_node_hears_every_list(generation: str) -> None:
    python = PEERS / generation / "bin" / "python"
    if not python.exists():
        assert "ODS_REQUIRE_PEERS" not in os.environ, f"{python}: missing"
        pytest.skip(f"no {python}: `make peers`")
    domain = 100 + os.getpid() % 100
    env = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "HOME": str(PEERS)}
    node = Listener([str(python), str(ROOT / "tests" / "peers" / "ros2_node.py")], env)
    try:
        with bridge_of("ros2", f"domain = {domain}\nmost_hz = 100.0") as running:
            running.obstacles = [SWIMMER, ROCK]
            running.until(lambda: all(node.of(topic) for topic in (*OF_A_LIST, "/diagnostics")))
            time.sleep(1.0)
            before = {topic: len(node.of(topic)) for topic in OF_A_LIST}
            for _ in range(LISTS):
                running.publish()
                time.sleep(1.0 / LISTS_HZ)
            time.sleep(1.0)
            received = {topic: len(node.of(topic)) - before[topic] for topic in OF_A_LIST}
            print(f"{generation}: of {LISTS} lists {received}", file=sys.stderr)
            assert received == dict.fromkeys(OF_A_LIST, LISTS)
            reported = node.of("/ods/markers")[-1]
            assert reported["frame"] == "map"
            assert reported["enu"][0] == [50.0, 100.0, -5.0]
            assert node.of("/ods/clearance")[-1]["points"] == 72
            hashes = node.of("hashes")
            assert len(hashes) == len(OF_A_LIST) + 1
            assert all(each["theirs"] == each["own"] and len(each["own"]) == 1 for each in hashes), hashes
            running.valid = False
            running.until(lambda: node.of("/diagnostics")[-1]["level"] == ERROR)
            silent = len(node.of("/ods/markers"))
            withheld = running.counts("withheld_lists")
            running.until(lambda: running.counts("withheld_lists") > withheld + 7)
            assert len(node.of("/ods/markers")) == silent
    finally:
        node.close()
