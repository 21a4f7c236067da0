"""What in_vcan promises: two real buses, kernel time stamps, and links that can be broken and repaired."""

import errno
from collections import Counter
from collections.abc import Callable

import can
import pytest

from in_vcan import links
from ods.base import clock
from ods.nav_bridge.can.socketcan_bus import SocketcanBus
from ods.nav_bridge.can.stamp_clock import StampClock

FRAME = can.Message(arbitration_id=0x185, data=b"\x01\x02\x03", is_extended_id=False)


def on(channel: str) -> can.BusABC:
    return can.Bus(channel, "socketcan", ignore_config=True)


def test_a_frame_arrives_on_its_bus_alone_with_a_kernel_time_stamp(vcan0: str, vcan1: str) -> None:
    with on(vcan0) as near, on(vcan0) as far, on(vcan1) as other:
        before_s = 1e-9 * clock.utc_ns()
        far.send(FRAME)
        after_s = 1e-9 * clock.utc_ns()
        received = near.recv(1.0)
        assert received is not None
        assert received.equals(FRAME, timestamp_delta=None, check_channel=False, check_direction=False)
        assert before_s - 1e-6 <= received.timestamp <= after_s  # stamped when it was sent, not when it was read
        assert other.recv(0.05) is None


@pytest.mark.parametrize(
    ("breaks", "repairs", "said"),
    [(links.down, links.up, errno.ENETDOWN), (links.delete, links.make, errno.ENODEV)],
    ids=["down-up", "delete-make"],
)
def test_a_broken_link_is_an_error_and_mends(
    vcan0: str, breaks: Callable[[str], None], repairs: Callable[[str], None], said: int
) -> None:
    with on(vcan0) as far:
        breaks(vcan0)
        assert not links.is_up(vcan0)
        with pytest.raises(can.CanOperationError) as caught:
            far.send(FRAME)
        assert caught.value.error_code in (said, errno.ENETDOWN, errno.ENXIO)
    repairs(vcan0)
    with on(vcan0) as near, on(vcan0) as far:
        far.send(FRAME)
        assert near.recv(1.0) is not None


def test_frames_that_the_kernel_drops_are_counted(vcan0: str) -> None:
    counters: Counter[str] = Counter()
    near = SocketcanBus(vcan0, StampClock(counters), counters, buffer_bytes=4096)
    with on(vcan0) as far:
        for _ in range(200):
            far.send(FRAME)
        read = len(list(near.receive(1000, 0)))
        assert read < 200
        far.send(FRAME)
        assert len(list(near.receive(1000, 0))) == 1
    near.shutdown()
    assert read + counters["can_overflow"] == 200
