"""Whose status it is, and what it tells."""

from collections import Counter

import pytest
from hypothesis import given, strategies as st

from ods.sonar_link.oculus.status import StatusBoard, model_of
from tests.sonar_link.oculus import wire

S = 1_000_000_000


def board(*datagrams: bytes) -> StatusBoard:
    made = StatusBoard("192.168.2.3", Counter())
    for datagram in datagrams:
        made.receive(datagram, S)
    return made


def test_the_own_status_is_kept_for_five_seconds() -> None:
    made = board(wire.status())
    status = made.own(6 * S)
    assert status is not None
    assert (model_of(status), status.device, made.problems(6 * S)) == ("M750d", 7892, [])
    assert made.own(6 * S + 1) is None
    assert made.counters == {"statuses": 1}


def test_another_sonars_status_is_not_ours() -> None:
    made = board(wire.status("192.168.2.9", state=1 << 16))
    assert made.own(S) is None
    assert made.problems(S) == []
    assert made.why_unreachable(S) == "a sonar at 192.168.2.9 is received (M750d): is sonar.port correct?"
    assert made.counters == {"other_statuses": 1}


@pytest.mark.parametrize(
    ("datagrams", "why"),
    [
        ([], "no status of any sonar is received"),
        ([wire.status()], "is this machine in its network?"),
        ([wire.status(client="192.168.2.77")], "192.168.2.77 has its connection"),
        ([wire.status("10.0.0.1", part=9999)], "10.0.0.1 is received (part 9999)"),
    ],
)
def test_why_a_sonar_cannot_be_reached(datagrams: list[bytes], why: str) -> None:
    assert why in board(*datagrams).why_unreachable(S)


@pytest.mark.parametrize(
    ("state", "said"),
    [
        (3, []),
        (2, []),
        (0, ["the sonar has halted: its magnetic switch"]),
        (1 | 6 << 3, ["the sonar has halted: a brownout"]),
        (1 | 7 << 3, ["the sonar has halted: of unknown reason"]),
        (3 | 1 << 14, ["the sonar is hot: is it in the water?"]),
        (3 | 3 << 14, ["the sonar is too hot and does not ping: is it in the water?"]),
        (3 | 1 << 16, ["the sonar's transmitter has failed"]),
    ],
)
def test_what_the_state_complains_of(state: int, said: list[str]) -> None:
    assert board(wire.status(state=state)).problems(S) == said


@given(st.one_of(st.binary(max_size=300), st.binary(min_size=140, max_size=140).map(lambda end: b"SO" + end)))
def test_any_datagram_is_taken_or_counted(datagram: bytes) -> None:
    made = board(datagram)
    assert sum(made.counters.values()) == 1
    assert all(isinstance(text, str) for text in [*made.problems(S), made.why_unreachable(S)])
