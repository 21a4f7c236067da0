"""A hanging sonar: its speckle comes again though the vehicle has moved on."""

import math

import msgspec
import numpy as np
import pytest

from ods.base.frames import geometry
from ods.messages import Ping, Pose
from ods.pipeline.interference.repeated_image import RepeatedImage
from ods.pipeline.prepared.plan import PingError
from tests.pipeline.pings import make_ping

PERIOD_S = 0.15
ZERO = (0.0, 0.0, 0.0)
RNG = np.random.default_rng(0)


def pose(north_m: float, yaw: float = 0.0) -> Pose:
    w, x, y, z = geometry.quat_from_euler(0.0, 0.0, yaw).tolist()
    return Pose(0, 0, 0, (north_m, 0.0, 0.0), (w, x, y, z), ZERO, ZERO, ZERO)


def image() -> bytes:
    return RNG.rayleigh(20.0, (60, 1000)).astype(np.uint8).tobytes()


class Sonar:
    """Shows images while the vehicle moves."""

    def __init__(self, speed_mps: float = 1.0, turn_rps: float = 0.0) -> None:
        self.judge, self.number = RepeatedImage(), 0
        self.speed_mps, self.turn_rps = speed_mps, turn_rps

    def show(self, data: bytes) -> str:
        self.number += 1
        t_s = self.number * PERIOD_S
        self.judge.add_pose(pose(self.speed_mps * t_s, self.turn_rps * t_s))
        ping: Ping = make_ping(np.zeros((60, 1000), np.uint8), t_ns=round(t_s * 1e9))
        return self.judge.judge(msgspec.structs.replace(ping, data=data))

    def refusal(self, data: bytes) -> str:
        """Why the image is refused; "": it is not."""
        try:
            self.show(data)
        except PingError as error:
            return str(error)
        return ""


def changed(data: bytes, number: int) -> bytes:
    other = bytearray(data)
    other[number] ^= 1
    return bytes(other)


@pytest.mark.parametrize("turn", [1, 2, 8, 24])
def test_images_in_turn_are_refused_within_two_seconds(turn: int) -> None:
    sonar, images = Sonar(), [image() for _ in range(turn)]
    for data in images:
        assert sonar.show(data) == ""
    reported = [sonar.refusal(changed(images[number % turn], number)) for number in range(30)]
    assert all("the sonar hangs" in each for each in reported[round(2.0 / PERIOD_S) :])
    assert sonar.show(image()) == ""


def test_a_slow_or_turning_vehicle_is_waited_for() -> None:
    sonar, data = Sonar(speed_mps=0.1), image()
    reported = [sonar.show(changed(data, number)) for number in range(66)]
    assert reported[30].startswith("the image has not changed for")
    assert "moved by 1.0 m" in next(filter(None, (sonar.refusal(changed(data, number)) for number in range(10))))
    turning = Sonar(speed_mps=0.0, turn_rps=math.radians(5.0))
    assert "turned by 5 deg" in next(filter(None, (turning.refusal(changed(data, number)) for number in range(10))))


def test_at_rest_an_image_that_stands_still_is_reported_and_taken() -> None:
    sonar, data = Sonar(speed_mps=0.0), image()
    reported = [sonar.show(changed(data, number)) for number in range(100)]
    assert reported[:6] == [""] * 6
    assert reported[-1] == "the image has not changed for 14.8 s"
    assert sonar.show(image()) == ""


def test_frozen_speckle_under_noise_is_no_image_that_stands_still() -> None:
    sonar, still = Sonar(speed_mps=0.0), RNG.normal(size=(2, 60, 1000)) * 100.0
    for _ in range(20):
        field = still + RNG.normal(size=(2, 60, 1000)) * 20.0
        assert sonar.show(np.hypot(*field).clip(0, 255).astype(np.uint8).tobytes()) == ""


def test_an_image_of_nothing_is_no_concern() -> None:
    sonar = Sonar(speed_mps=5.0)
    assert [sonar.show(bytes(60_000)) for _ in range(20)] == [""] * 20
