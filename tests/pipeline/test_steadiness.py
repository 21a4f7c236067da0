"""Settings that change from ping to ping are said, a change of range and a profile of the water are not."""

import numpy as np
import pytest

from ods.pipeline.steadiness import Steadiness
from tests.pipeline.pings import make_ping

FRAME = np.ones((2, 50), np.uint8)


def said(spacings_m: list[float], speeds: list[float]) -> list[str]:
    judge = Steadiness()
    return [
        judge.judge(make_ping(FRAME, dr_m=spacing, sound_speed=speed))
        for spacing, speed in zip(spacings_m, speeds, strict=True)
    ]


@pytest.mark.parametrize(("second", "text"), [(0.025, "0.025 to 0.05 m"), (0.1, "0.05 to 0.1 m")])
def test_a_spacing_that_alternates_is_said_within_four_pings_until_it_rests(second: float, text: str) -> None:
    lines = said([0.05, second] * 10 + [0.05] * 15, [1500.0] * 35)
    assert not lines[2]
    assert all(text in line and "sample spacing changes" in line for line in lines[4:20])
    assert not lines[-1]


def test_a_sound_speed_that_jumps_is_said_once_though_the_spacing_follows() -> None:
    speeds = [1450.0, 1550.0] * 10
    lines = said([0.05 * speed / 1500.0 for speed in speeds], speeds)
    assert lines[-1] == "the sonar's sound speed changes from ping to ping (1450 to 1550 m/s)"


def test_a_change_of_range_and_a_profile_are_none() -> None:
    assert not any(said([0.05] * 20 + [0.1] * 20, np.linspace(1480.0, 1510.0, 40).tolist()))
