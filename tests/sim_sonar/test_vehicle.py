"""The vehicle on CAN: it obeys RPDO 1, and stops where none comes. A bus in memory, and a clock that a test moves."""

import math
from collections.abc import Iterator
from pathlib import Path
from queue import Empty

import can
import pytest

from ods.base import clock
from ods.messages import VehicleTruth
from ods.sim_sonar.device.live import Mission
from ods.sim_sonar.device.vehicle import LiveVehicle, VehicleNode, steered_of
from ods.sim_sonar.ins.canopen_node import shared
from ods.sim_sonar.scene.settings import VehiclePath
from ods.sim_sonar.settings import SteeredVehicleSettings, VehicleSettings

EDS = Path(__file__).parents[2] / "config" / "vehicle.eds"
PERIOD_S = 0.15
EAST_SLOWLY = bytes.fromhex("5c3de803204e0000")
"""15708 * 0.0001 rad, 1000 mm/s, 20000 mm."""
SETTINGS = SteeredVehicleSettings(eds=EDS, can_do=VehicleSettings(acceleration_m_s2=0.5))


class Bench:
    """The vehicle, its bus, and time."""

    def __init__(self, near: can.BusABC, far: can.BusABC) -> None:
        self.now_ns = 10**12
        self.bus = near
        self.vehicle = steered_of(SETTINGS, VehiclePath(position_ned=(1.0, 2.0, 20.0), velocity_ned=(1.5, 0.0, 0.0)))
        self.node = VehicleNode(shared(far, 1)[0], EDS, 6)
        self.live = LiveVehicle(self.vehicle, self.node, Mission(self.now_ns, []), PERIOD_S)

    def wait(self, seconds: float, *frames: can.Message) -> VehicleTruth:
        """Let time go, with these frames in every tenth of a second; return the newest truth."""
        until_ns, sent_ns = self.now_ns + round(seconds * clock.NS), 0
        while self.now_ns < until_ns:
            if frames and self.now_ns - sent_ns >= clock.NS // 10:
                sent_ns = self.now_ns
                for frame in frames:
                    self.bus.send(frame)
            self.now_ns = self.live.step()
        try:
            while True:
                newest = self.live.truths.get_nowait()
        except Empty:
            return newest


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    with (
        can.Bus("vehicle", "virtual", ignore_config=True) as near,
        can.Bus("vehicle", "virtual", ignore_config=True) as far,
    ):
        made = Bench(near, far)
        monkeypatch.setattr(clock, "monotonic_ns", lambda: made.now_ns)
        yield made


def rpdo(data: bytes, can_id: int = 0x206, extended: bool = False) -> can.Message:
    return can.Message(arbitration_id=can_id, data=data, is_extended_id=extended)


def test_it_turns_and_slows_as_rpdo_1_says(bench: Bench) -> None:
    end = bench.wait(20.0, rpdo(EAST_SLOWLY))
    north, east, down = end.velocity_ned
    assert (north, east, down) == pytest.approx((0.0, 1.0, 0.0), abs=0.01)
    assert end.position_ned[1] > 10.0
    assert not end.stopped
    assert bench.live.stops == 0


def test_a_silent_bus_stops_it_after_the_event_timer_and_a_set_point_starts_it(bench: Bench) -> None:
    assert not bench.wait(0.9).stopped
    assert bench.wait(0.3).stopped
    still = bench.wait(5.0)
    assert math.hypot(*still.velocity_ned) == 0.0
    assert still.position_ned[0] < 1.0 + 1.2 * 1.5 + 1.5**2 / (2 * 0.5) + 0.3
    going = bench.wait(5.0, rpdo(EAST_SLOWLY))
    assert (going.stopped, bench.live.stops) == (False, 1)
    assert math.hypot(*going.velocity_ned) > 0.9


@pytest.mark.parametrize(
    "frame",
    [rpdo(EAST_SLOWLY, 0x207), rpdo(EAST_SLOWLY, extended=True), rpdo(EAST_SLOWLY[:7])],
    ids=["another node's", "29 bits", "too short"],
)
def test_what_is_no_set_point_of_its_own_is_none(bench: Bench, frame: can.Message) -> None:
    assert bench.wait(3.0, frame).stopped
    assert bool(bench.node.counters["short_set_points"]) == (len(frame.data) < 8)


def test_it_obeys_in_the_state_operational_only_and_tells_its_state(bench: Bench) -> None:
    reported = []
    bench.wait(0.1)
    while (message := bench.bus.recv(0)) is not None:
        reported.append((message.arbitration_id, bytes(message.data)))
    assert reported[:2] == [(0x706, b"\0"), (0x706, b"\5")]  # boot-up, then heartbeat
    bench.bus.send(rpdo(b"\x02\x06", 0x000))
    assert bench.wait(3.0, rpdo(EAST_SLOWLY)).stopped
    bench.bus.send(rpdo(b"\x01\x00", 0x000))
    assert not bench.wait(1.0, rpdo(EAST_SLOWLY)).stopped


def test_where_it_will_be_is_known_for_as_long_as_an_image_is_made_ahead(bench: Bench) -> None:
    """What a ping was made of before is what the INS says then."""
    bench.wait(3.0, rpdo(EAST_SLOWLY))
    t_s = (bench.now_ns - 10**12) / clock.NS + PERIOD_S
    foretold = bench.vehicle.position(t_s)
    bench.wait(PERIOD_S + 0.1, rpdo(bytes(8)))
    assert bench.vehicle.position(t_s) == pytest.approx(foretold, abs=1e-12)


def test_two_devices_share_an_end_and_both_hear_all() -> None:
    with can.Bus("both", "virtual", ignore_config=True) as near, can.Bus("both", "virtual", ignore_config=True) as far:
        first, second = shared(far, 2)
        near.send(rpdo(b"\x01"))
        near.send(rpdo(b"\x02"))
        received = [[end.recv(), end.recv(), end.recv()] for end in (first, second)]
        assert [[each.data[0] if each else None for each in one] for one in received] == [[1, 2, None]] * 2
        first.send(rpdo(b"\x03"))
        assert second.recv() is None
        answer = near.recv(0)
        assert answer is not None
        assert answer.data == b"\x03"
