"""Bridges as processes on real sockets: what is valid arrives, what is not does not, and nothing stops them."""

import itertools
import json

import pynmea2
import pytest

from tests.bridge.moos_datagrams import read
from tests.bridge.played import Bridge, bridge, drained, receiver
from tests.bridge.samples import ROCK, SWIMMER

pytestmark = pytest.mark.slow


def started(running: Bridge) -> None:
    running.obstacles = [SWIMMER, ROCK]
    running.until(lambda: running.counts("sent_lists") > 0)


def ids(name: str, data: bytes) -> list[int]:
    """Return the ids that a datagram tells, read by who is not ODS."""
    if name == "json":
        return [each["id"] for each in json.loads(data)["obstacles"]]
    if name == "ttm":
        return [int(pynmea2.parse(data.decode(), check=True).data[10].removeprefix("ODS"))]
    if name == "mavlink":
        dialect = pytest.importorskip("pymavlink.dialects.v20.ardupilotmega")
        points = dialect.MAVLink(None).parse_buffer(data)
        return [each.obstacle_id for each in points if each.obstacle_id != 65535]
    return [int(read(data).text.partition("label=ods_")[2].partition(",")[0])]


@pytest.mark.parametrize("name", ["json", "ttm", "moos", "mavlink"])
def test_lists_arrive_while_they_are_valid_and_silence_follows(name: str) -> None:
    keys = "most_hz = 100.0"
    if name == "mavlink":
        pytest.importorskip("pymavlink")
        keys += '\nform = "3d"\nmost_m = 100.0'
    with receiver() as peer, bridge(name, peer.getsockname()[1], keys) as running:
        started(running)
        reported = [number for data in drained(peer) for number in ids(name, data)]
        assert reported[:2] == [7, 300]  # the nearest first
        assert running.well()

        def silent(why: str) -> None:
            """Wait until it says why it is silent, and see that nothing comes from then on; then repair it."""
            running.until(lambda: running.says(why))
            drained(peer)
            withheld = running.counts("withheld_lists")
            running.until(lambda: running.counts("withheld_lists") > withheld + 4)
            assert drained(peer) == []
            running.valid, running.posed, running.late_s = True, True, 0.0
            running.until(lambda: bool(drained(peer)) and running.well())

        running.valid = False
        silent("nothing is sent: the list is not valid: the INS is silent")
        running.late_s = 1.5
        silent("nothing is sent: the list is 1.5 s old")
        running.posed = False
        silent("nothing is sent: the vehicle's pose is not known")
        running.published = False
        running.until(lambda: running.says("nothing is sent: no obstacle list for"))
        running.published = True
        running.until(lambda: bool(drained(peer)) and running.well())


def test_a_receiver_that_goes_and_comes_is_reported_and_served_again() -> None:
    with receiver() as peer:
        port = peer.getsockname()[1]
    with bridge("json", port) as running:
        running.obstacles = [ROCK]
        running.until(lambda: running.says(f"127.0.0.1 port {port}: no process listens there"))
        assert running.counts("refused_datagrams") > 0
        with receiver(port) as peer:
            running.until(lambda: bool(drained(peer)))
            running.until(running.well)


def test_an_empty_list_is_reported_by_json() -> None:
    with receiver() as peer, bridge("json", peer.getsockname()[1]) as running:
        running.until(lambda: running.counts("sent_lists") > 0)
        reported = json.loads(drained(peer)[-1])
        assert (reported["obstacles"], reported["left_out"]) == ([], 0)


def test_no_more_lists_a_second_than_wanted() -> None:
    with receiver() as peer, bridge("json", peer.getsockname()[1], "most_hz = 1.0") as running:
        started(running)
        running.until(lambda: running.counts("sent_lists") >= 4)
        sent = [json.loads(data)["utc_ms"] for data in drained(peer)]
        assert running.counts("paced_lists") > 0
        assert all(later - earlier >= 990 for earlier, later in itertools.pairwise(sent))
