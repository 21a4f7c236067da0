"""When the fire message is sent, and what is said of a sonar that does something else."""

from collections import Counter
from typing import Any

import msgspec
import pytest

from ods.sonar_link.oculus import messages
from ods.sonar_link.oculus.control import REPEAT_S, FireControl, differences
from ods.sonar_link.oculus.messages import Fire
from ods.sonar_link.oculus.settings import OculusSettings

S = 1_000_000_000
SETTINGS = OculusSettings(range_m=20.0, gain_percent=60.0, settle_s=10.0)
OBEYED = SETTINGS.fire()


def control(settings: OculusSettings = SETTINGS) -> FireControl:
    made = FireControl(settings, Counter())
    made.connected(0)
    return made


def test_nothing_is_sent_without_a_connection() -> None:
    made = FireControl(SETTINGS, Counter())
    assert made.requests(S) == []
    made.connected(S)
    assert made.requests(S) == [messages.encode_fire(OBEYED, 2)]
    made.lost()
    assert made.requests(9 * S) == []


def test_it_is_sent_again_as_long_as_no_ping_comes_and_not_with_every_call() -> None:
    made = control()
    sent = [ms for ms in range(0, 5000, 50) if made.requests(ms * S // 1000)]
    assert sent == [0, 2000, 4000]
    assert made.counters["control_requests"] == 3


def test_a_sonar_that_pings_as_asked_is_left_alone() -> None:
    made = control()
    made.requests(0)
    for tenth in range(1, 300):
        made.receive(OBEYED._replace(ping_rate=195), tenth * S // 10)
        assert made.requests(tenth * S // 10) == []
    assert made.problems(30 * S) == []


def test_one_that_pings_otherwise_is_asked_again_and_reported_of_when_it_had_the_time() -> None:
    made = control()
    sent = 0
    for tenth in range(110):
        sent += len(made.requests(tenth * S // 10))
        made.receive(OBEYED._replace(range_m=10.0), tenth * S // 10)
        assert bool(made.problems(tenth * S // 10)) == (tenth > 100)
    assert sent == 6
    assert made.problems(11 * S) == ["the sonar did not accept range 20 m: it reports 10 m"]
    assert made.counters["control_lost"] == 0  # it had never taken it


def test_settings_that_are_lost_later_are_counted_and_asked_for_again() -> None:
    made = control()
    made.requests(0)
    made.receive(OBEYED, S)
    made.receive(OBEYED._replace(mode=2, gain_percent=76.0), 20 * S)
    assert made.counters["control_lost"] == 1
    assert made.problems(21 * S) == []
    assert len(made.requests(21 * S + round(REPEAT_S * S))) == 1


@pytest.mark.parametrize(
    ("reported", "said"),
    [
        ({"mode": 2}, "mode 1: it reports 2"),
        ({"gamma": 255}, "gamma 127: it reports 255"),
        ({"range_m": float("nan")}, "range 20 m: it reports nan m"),
        ({"gain_percent": 59.0}, "gain 60 %: it reports 59 %"),
        ({"salinity_ppt": 0.0}, "salinity 35 ppt: it reports 0 ppt"),
    ],
)
def test_each_difference_is_said_in_plain_words(reported: dict[str, Any], said: str) -> None:
    assert differences(OBEYED, OBEYED._replace(**reported)) == [said]


def test_the_high_mode_tells_its_gain_on_another_scale_and_a_computed_sound_speed_is_its_own() -> None:
    high = OBEYED._replace(mode=2)
    assert differences(high, high._replace(gain_percent=76.0, sound_speed=1490.7)) == []
    assert differences(OBEYED, OBEYED._replace(gain_percent=76.0)) != []


def test_a_reported_sound_speed_is_compared_and_salinity_is_not() -> None:
    fire = OculusSettings(sound_speed=1480.0).fire()
    assert differences(fire, fire._replace(salinity_ppt=0.0)) == []
    assert differences(fire, fire._replace(sound_speed=1500.0)) == ["sound speed 1480 m/s: it reports 1500 m/s"]


def test_the_fire_message_of_all_settings() -> None:
    settings = OculusSettings(
        mode="high", range_m=5.0, gain_percent=30.0, gain_assist=True, gamma=255, sound_speed=1500.0, salinity_ppt=1.0,
        ping_rate_hz=40, beams=256, sample_bits=32, network_mbps=100,
    )  # fmt: skip
    assert settings.fire() == Fire(2, 2, 100, 255, 0x1B, 5.0, 30.0, 1500.0, 1.0, 0x200)
    assert OculusSettings().fire() == Fire(1, 0, 255, 127, 0x49, 40.0, 50.0, 0.0, 35.0, 0)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("mode", "flexi"), ("range_m", 0.0), ("range_m", 1e6), ("gain_percent", 101), ("gamma", 0), ("gamma", 256),
        ("sound_speed", 340.0), ("salinity_ppt", -1), ("ping_rate_hz", 20), ("beams", 300), ("sample_bits", 24),
        ("network_mbps", 0), ("message_version", 3), ("status_port", 70000),
    ],
)  # fmt: skip
def test_what_no_sonar_can_do_is_refused_by_its_key(key: str, value: object) -> None:
    with pytest.raises(msgspec.ValidationError, match=key):
        msgspec.convert({key: value}, OculusSettings)


def test_32_bits_need_the_second_version() -> None:
    with pytest.raises(msgspec.ValidationError, match="message_version"):
        msgspec.convert({"sample_bits": 32, "message_version": 1}, OculusSettings)
