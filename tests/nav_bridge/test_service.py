"""The nav process end to end: simulated INS -> CAN -> NavWorker in the real work loop -> `pose` over ZeroMQ.

On a real SocketCAN interface: tests/vcan/test_nav_service.py.
"""

import math
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import pairwise

import can
import msgspec
import numpy as np
import pytest
from can.interfaces.slcan import slcanBus

from ods.base.geodesy import LocalFrame
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.messages import Pose
from ods.nav_bridge.service import NavWorker
from ods.nav_bridge.settings import CanSettings
from ods.sim_sonar.ins.dbc_ins import SimulatedDbcIns
from ods.sim_sonar.ins.slcan_hub import SlcanHub
from tests.nav_bridge.nav_chain import CONFIG, MS, SITE, STEP_M, Client, Vehicle, nav_process, wired_up

pytestmark = pytest.mark.slow

ROUNDED = math.cos(1.5e-4 / 2.0)
"""Cosine of half of the largest turn that rounding three angles to 1e-4 rad makes."""


@pytest.fixture(params=["slcan", "virtual"])
def wired(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[NavWorker, Client, Vehicle]]:
    """Everything wired up on each kind of bus."""
    run_dir = tmp_path_factory.mktemp("nav")
    with ExitStack() as stack:
        if request.param == "virtual":
            near = CanSettings(interface="virtual", channel="nav-service")
            far = can.Bus("nav-service", "virtual", ignore_config=True)
        else:
            hub = stack.enter_context(SlcanHub([run_dir / "can0", run_dir / "can1"]))
            near = CanSettings(interface="slcan", channel=str(hub.links[0]), bitrate=500_000)
            far = slcanBus(str(hub.links[1]), sleep_after_open=0.0, timeout=0.0)
        yield stack.enter_context(wired_up(run_dir, near, far))


IN_A_ROW = 100


def in_a_row(poses: list[Pose]) -> int:
    """Return how many of the newest poses are of instants that were sent one after another."""
    sent = [round(pose.position_ned[0] / STEP_M) for pose in poses]
    return next((k for k, (later, earlier) in enumerate(pairwise(sent[::-1]), 1) if later - earlier != 1), len(sent))


def test_every_epoch_arrives_as_it_was_sent(wired: tuple[NavWorker, Client, Vehicle]) -> None:
    """A machine that is starved tears an epoch now and then, as the adapter has no stamps, but not one in a hundred."""
    _, client, vehicle = wired
    client.until(lambda: len(client.poses) > 120 and in_a_row(client.poses) >= IN_A_ROW, 30.0)
    assert [pose.seq for pose in client.poses] == list(range(client.poses[0].seq, client.poses[-1].seq + 1))
    lateness = []
    for pose in client.poses:
        position, attitude, velocity, sent_ns = vehicle.sent[round(1000 * pose.position_ned[0])]
        np.testing.assert_allclose(pose.position_ned, position, atol=0.5e-3 + 1e-9)
        np.testing.assert_allclose(pose.velocity_body, velocity, atol=0.5e-3 + 1e-9)
        assert abs(float(np.dot(pose.attitude, attitude))) > ROUNDED
        lateness.append(pose.t_ns - sent_ns)
    assert min(lateness) > -1.5 * MS  # stamps are whole milliseconds
    assert np.median(lateness[64:]) < 50 * MS  # though the INS's clock is 40 s ahead
    client.until(lambda: client.health is not None and client.health.counters["poses"] > 100)
    assert client.health is not None
    assert client.health.ready
    assert client.health.problems == []  # though the INS's UTC is 40 s ahead: no pose depends on it
    assert not client.says("pose")


def test_silence_is_reported_while_it_lasts_and_lived_down(wired: tuple[NavWorker, Client, Vehicle]) -> None:
    _, client, vehicle = wired
    client.until(lambda: len(client.poses) > 20)
    vehicle.mute = True
    client.until(lambda: client.says("no pose for") and client.says("no CAN frame for"))
    assert client.health is not None
    (reason,) = client.health.problems
    assert "heartbeat" not in reason
    seen = len(client.poses)
    vehicle.mute = False
    client.until(lambda: len(client.poses) > seen + 20)
    client.until(lambda: not client.says("no pose"))


def test_an_ins_by_dbc_on_an_adapter(tmp_path_factory: pytest.TempPathFactory) -> None:
    run_dir = tmp_path_factory.mktemp("nav")
    dbc = load(CONFIG / "onboard-sbg.toml", OnboardConfig).nav.dbc
    assert dbc is not None
    with ExitStack() as stack:
        hub = stack.enter_context(SlcanHub([run_dir / "can0", run_dir / "can1"]))
        far = slcanBus(str(hub.links[1]), sleep_after_open=0.0, timeout=0.0)
        stack.callback(far.shutdown)
        settings = CanSettings(interface="slcan", channel=str(hub.links[0]), bitrate=500_000)
        _, client = stack.enter_context(nav_process(run_dir, settings, msgspec.structs.replace(dbc, window_s=0.05)))
        client.until(lambda: client.says("none of the 8 messages mapped from sbg.dbc has come"))
        frame = LocalFrame(SITE.latitude_deg, SITE.longitude_deg)
        vehicle = Vehicle(far, SimulatedDbcIns(far, CONFIG / "sbg.dbc", frame))
        stack.callback(vehicle.close)
        vehicle.start()
        client.until(lambda: len(client.poses) > 100)
        for pose in client.poses:
            count = round(1000.0 * (pose.position_ned[2] - 4.0))
            position, attitude, velocity, _ = vehicle.sent[50 * count]
            np.testing.assert_allclose(pose.position_ned, position, atol=0.012)
            np.testing.assert_allclose(pose.velocity_body, velocity, atol=0.012)
            assert abs(float(np.dot(pose.attitude, attitude))) > ROUNDED
        vehicle.mute = True
        client.until(lambda: client.says("no CAN frame for"))
        seen = len(client.poses)
        vehicle.mute = False
        client.until(lambda: len(client.poses) > seen + 20)
        client.until(lambda: not client.says("no pose"))
        assert far.recv(0) is None  # nobody answers an INS by DBC


def test_an_adapter_pulled_out_and_put_back(tmp_path_factory: pytest.TempPathFactory) -> None:
    run_dir = tmp_path_factory.mktemp("nav")
    with ExitStack() as stack:
        hub = stack.enter_context(SlcanHub([run_dir / "can0", run_dir / "can1"]))
        settings = CanSettings(interface="slcan", channel=str(hub.links[0]), bitrate=500_000)
        far = slcanBus(str(hub.links[1]), sleep_after_open=0.0, timeout=0.0)
        stack.callback(far.shutdown)
        worker, client = stack.enter_context(nav_process(run_dir, settings))
        vehicle = Vehicle(far)
        stack.callback(vehicle.close)
        vehicle.start()
        client.until(lambda: len(client.poses) > 20)
        hub.unplug(0)
        client.until(lambda: client.says("no such file or directory"))
        assert client.health is not None
        assert not client.health.ready
        hub.plug(0)
        seen = len(client.poses)
        client.until(lambda: len(client.poses) > seen + 50)
        client.until(lambda: client.health is not None and client.health.ready)
        assert worker.service.counters["can_lost"] == 1
        assert worker.service.counters["can_opened"] == 2


def test_the_node_is_alive_on_the_bus_and_commands_nobody_unasked(
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    run_dir = tmp_path_factory.mktemp("nav")
    with ExitStack() as stack:
        far = can.Bus("nav-alive", "virtual", ignore_config=True)
        stack.callback(far.shutdown)
        stack.enter_context(nav_process(run_dir, CanSettings(interface="virtual", channel="nav-alive")))
        far.send(can.Message(arbitration_id=0x705, data=b"\x7f", is_extended_id=False))
        received: list[tuple[int, bytes]] = []
        while len(received) < 3:
            message = far.recv(5.0)
            assert message is not None
            if message.arbitration_id != 0x0A0:  # the emergency that there is no pose
                received.append((message.arbitration_id, bytes(message.data)))
        assert received == [(0x720, b"\x00"), (0x720, b"\x05"), (0x720, b"\x05")]
