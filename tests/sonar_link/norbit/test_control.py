"""Commands one by one, each answer awaited; what the sonar did not accept is said."""

from collections import Counter

import msgspec
import pytest
from hypothesis import given, strategies as st

from ods.sonar_link.norbit.control import LONGEST_LINE, Command, CommandControl
from ods.sonar_link.norbit.settings import NorbitSettings

S = 1_000_000_000
COMMANDS = [Command("set_mode", (0,)), Command("set_range", (0.0, 40.0)), Command("set_power", (1,))]


def made(now_ns: int = 0) -> CommandControl:
    control = CommandControl(COMMANDS, Counter())
    control.connected(now_ns)
    return control


def test_each_command_waits_for_the_answer_to_the_one_before() -> None:
    control = made()
    control.receive(b"NORBIT WBMS\r\nset_mode is a command\r\n", 0)  # a greeting answers nothing
    assert control.requests(0) == [b"set_mode 0\r\n"]
    assert control.requests(1) == []
    control.receive(b"set_mode 0", 2)
    assert control.requests(2) == []
    control.receive(b" # forward\r\n", 3)
    assert control.requests(3) == [b"set_range 0 40\r\n"]
    control.receive(b"unasked\nset_range 0.0 40.2 # in meter 7\n", 4)
    assert control.requests(4) == [b"set_power 1\r\n"]
    control.receive(b"power 1\r\n", 5)  # some leave out `set_`
    assert control.requests(10 * S) == []
    assert control.problems() == []
    assert +control.counters == {"control_requests": 3, "control_acknowledged": 3}


def test_what_it_answers_otherwise_or_not_at_all_is_said() -> None:
    control = made()
    control.requests(0)
    control.receive(b"set_mode 1\r\n", 0)
    sent = [request for turn in range(40) for request in control.requests(turn * S // 4)]
    assert sent == [b"set_range 0 40\r\n"] * 3 + [b"set_power 1\r\n"] * 3
    assert control.problems() == [
        "the sonar did not accept set_mode 0: it reports 1",
        "the sonar did not answer set_range 0 40",
        "the sonar did not answer set_power 1",
    ]
    assert control.counters["control_refused"] == 1
    assert control.counters["control_lost"] == 2


def test_a_port_that_answers_nothing_is_one_problem_not_one_for_each_command() -> None:
    control = made()
    for turn in range(60):
        control.requests(turn * S // 4)
    assert control.problems() == ["the sonar does not answer commands: is `command_port` that of a WBMS?"]


def test_all_is_sent_again_after_each_connection_and_nothing_without_one() -> None:
    control = CommandControl(COMMANDS, Counter())
    assert control.requests(0) == []
    control.connected(0)
    control.requests(0)
    control.receive(b"set_mode 0\r\nset_ra", 1)
    control.lost()
    assert control.requests(2) == []
    control.connected(3)
    assert control.requests(3) == [b"set_mode 0\r\n"]


@given(st.lists(st.binary(max_size=200)))
def test_whatever_it_answers_nothing_raises_and_little_is_kept(chunks: list[bytes]) -> None:
    control = made()
    for turn, chunk in enumerate([*chunks, b"\0" * LONGEST_LINE, b"x" * 10]):
        control.requests(turn * S)
        control.receive(b"set_mode " + chunk, turn * S)
        assert isinstance(control.problems(), list)
        assert len(control._bytes) <= LONGEST_LINE


def test_the_settings_are_the_document_s_commands_and_pinging_comes_last() -> None:
    words = [command.words for command in NorbitSettings(sound_speed="probe").commands()]
    assert words == [
        "set_mode 0", "set_flip 0", "set_gate_mode 0", "set_range 0 40", "set_direction 0", "set_opening_angle 140",
        "set_resolution 1000 512", "set_tx 400 80 15 500", "set_vga 50", "sound_velocity -1", "set_trigger_mode 2",
        "set_rate 10", "set_tp_rate 10", "set_power 1",
    ]  # fmt: skip
    manual = [
        command.words for command in NorbitSettings(gain_ramp_db=0.0, gain_db=12.0, sound_speed=1481.5).commands()
    ]
    assert manual[8:11] == ["set_vga 0", "set_gain 12", "sound_velocity 1481.5"]
    assert not any("sound" in command.name for command in NorbitSettings().commands())


@pytest.mark.parametrize("table", [{"beams": 100}, {"range_m": 700.0}, {"pulse_us": 5.0}, {"sound_speed": "sensor"}])
def test_what_the_sonar_cannot_do_is_refused(table: dict[str, object]) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(table, NorbitSettings)
