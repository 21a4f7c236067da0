"""The planner's client over real ZeroMQ: newest list, and a word of its own when the tracker is silent."""

import os
import socket
import time
from io import StringIO
from pathlib import Path

import msgspec
import pytest
import zmq
from rich.console import Console

from ods.base import clock
from ods.client import Obstacles
from ods.commands.watched.watch_screen import screen
from ods.messages import Health, ObstacleList
from ods.runtime import bus
from ods.runtime.processes import SUPERVISOR


def obstacle_list(seq: int) -> ObstacleList:
    return ObstacleList(seq, seq, 0, 0, 0, True, [], [])


def test_silence_is_said_and_ends(tmp_path: Path) -> None:
    client = Obstacles(tmp_path, stale_s=0.1)
    first = client.next()
    assert not first.valid
    assert first.ping_number == -1
    assert first.reasons[0].startswith("tracker: no obstacle list for 0.1")
    assert first.reasons[0].endswith(
        f" s: {tmp_path} has no socket of the tracker: does it run, and with this run_dir?"
    )

    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = bus.Publisher(context, tmp_path, "tracker")
    for seq in range(100):
        publisher.publish("obstacles", obstacle_list(seq))
        if (got := client.next()).valid:
            break
    assert got.valid
    silent = client.next()
    assert (silent.valid, silent.ping_number) == (False, got.ping_number)
    publisher.close()
    client.close()
    context.term()


def test_a_missing_right_is_said_with_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = bus.Publisher(context, tmp_path, "tracker")
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # as for a user who is not of the group
    socket = tmp_path / "tracker.sock"
    way_out = f"join the group {socket.group()} (and log in again), or run as {socket.owner()}"
    wanted = f": no permission to open {socket}: {way_out}"
    assert bus.unreachable_reason(tmp_path, "tracker") == wanted
    client = Obstacles(tmp_path, stale_s=0.1)
    assert client.next().reasons[0].endswith(wanted)
    text = Console(width=300, file=StringIO(), record=True)
    text.print(screen(None, {}, 0, wanted))
    assert f"no obstacle list yet{wanted}" in text.export_text()
    publisher.close()
    client.close()
    context.term()


def test_a_socket_that_a_process_left_behind_is_said(tmp_path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as left:
        left.bind(str(tmp_path / "tracker.sock"))
        left.listen()
        assert bus.unreachable_reason(tmp_path, "tracker") == ""
    wanted = f": no tracker runs with run_dir {tmp_path}: it has ended or was killed"
    assert bus.unreachable_reason(tmp_path, "tracker") == wanted


def test_only_the_newest_list_is_given(tmp_path: Path) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = bus.Publisher(context, tmp_path, "tracker")
    client = Obstacles(tmp_path, stale_s=0.2)
    while not client.next().valid:
        publisher.publish("obstacles", obstacle_list(0))
    for seq in range(1, 6):
        publisher.publish("obstacles", obstacle_list(seq))
    time.sleep(0.1)
    assert client.next().seq == 5
    assert not client.next().valid
    publisher.close()
    client.close()
    context.term()


def test_a_list_that_waited_for_a_slow_planner_is_not_taken_for_the_newest(tmp_path: Path) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = bus.Publisher(context, tmp_path, "tracker")
    client = Obstacles(tmp_path, stale_s=0.2)
    while not client.next().valid:
        publisher.publish("obstacles", obstacle_list(0))
    old_ns = clock.monotonic_ns() - 60 * clock.NS
    for seq in range(1, 2000):  # more than the queues hold: the last ones are lost
        publisher.publish("obstacles", msgspec.structs.replace(obstacle_list(seq), made_ns=old_ns))
    late = client.next()
    assert not late.valid
    assert late.reasons[0].startswith("tracker: no obstacle list for 60.")
    fresh = msgspec.structs.replace(obstacle_list(2000), made_ns=clock.monotonic_ns())
    publisher.publish("obstacles", fresh)
    assert client.next() == fresh
    publisher.close()
    client.close()
    context.term()


def test_why_the_tracker_is_silent_is_said(tmp_path: Path) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    supervisor = bus.Publisher(context, tmp_path, SUPERVISOR)
    down = Health("tracker", 0, 0, 0, 0, False, ["ended with code 2: no such observer"], {}, {}, {}, {}, 0.0, 0.0)
    client = Obstacles(tmp_path, stale_s=0.1)
    deadline = time.monotonic() + 10.0
    while ";" not in (reason := client.next().reasons[0]) and time.monotonic() < deadline:
        supervisor.publish(bus.HEALTH, down)
    assert reason.startswith("tracker: no obstacle list for ")
    assert reason.endswith(" s; ended with code 2: no such observer")
    supervisor.close()
    client.close()
    context.term()
