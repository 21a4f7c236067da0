"""Remote control: the records, when the sonar is asked again, and what planners are told; pure, with made-up time."""

import struct
from collections import Counter
from typing import Any

import pytest
from hypothesis import given, strategies as st

from ods.messages import SonarAnswer, SonarRequest
from ods.sonar_link.planner_requests import PlannerRequests
from ods.sonar_link.s7k import remote_control
from ods.sonar_link.s7k.control import RemoteControl
from ods.sonar_link.s7k.drf import DeviceId, S7kRecord
from ods.sonar_link.s7k.framer import RecordFramer
from ods.sonar_link.s7k.loss import Loss, RecordError
from ods.sonar_link.s7k.remote_control import ControlReply, ControlRequest
from ods.sonar_link.setting_requests import Controls, RequestState, SettingRequests
from tests.sonar_link.sonar_samples import UTC_NS

S = 1_000_000_000
NAN = float("nan")


def sent(control: RemoteControl, at_s: float) -> list[tuple[int, float]]:
    return [(r.command, round(remote_control.value_of(r), 3)) for r in control.requests(round(at_s * S))]


class Control(RemoteControl):
    """Remote control with its setting requests at hand."""

    def __init__(self, wanted: dict[str, float], subscription: tuple[int, ...] = ()) -> None:
        self.setting_requests = SettingRequests(wanted, repeat_s=1.0, attempts=3)
        super().__init__(self.setting_requests, subscription)


def control(**wanted: float) -> Control:
    made = Control(wanted)
    made.connected()
    return made


# the records


def test_the_request_field_by_field() -> None:
    made = remote_control.encode_request(remote_control.set_value(1003, 9, 50.0), UTC_NS, device=DeviceId(7000))
    (record,) = RecordFramer().feed(made)
    assert (record.record_type, record.device) == (7500, DeviceId(7000))
    assert record.body == struct.pack("<II16sf", 1003, 9, bytes(16), 50.0)
    assert remote_control.decode_request(record) == remote_control.set_value(1003, 9, 50.0)


def test_a_subscription_field_by_field() -> None:
    request = remote_control.subscribe(3, [7000, 7004, 7042])
    assert (request.command, request.parameters) == (1051, struct.pack("<4I", 3, 7000, 7004, 7042))
    assert remote_control.subscribed_types(request) == {7000, 7004, 7042}


def test_replies_field_by_field() -> None:
    request = ControlRequest(1003, 77, tracking=b"0123456789abcdef")
    (yes,) = RecordFramer().feed(remote_control.encode_reply(request, None, UTC_NS, DeviceId(1)))
    (no,) = RecordFramer().feed(remote_control.encode_reply(request, 5, UTC_NS, DeviceId(1)))
    assert (yes.record_type, yes.body) == (7501, struct.pack("<I16s", 77, request.tracking))
    assert (no.record_type, no.body) == (7502, struct.pack("<I16sI", 77, request.tracking, 5))
    assert [remote_control.decode_reply(r) for r in (yes, no)] == [ControlReply(77, None), ControlReply(77, 5)]


@given(st.sampled_from([7500, 7501, 7502]), st.binary(max_size=60))
def test_any_body_is_decoded_or_refused(record_type: int, body: bytes) -> None:
    record = S7kRecord(record_type, DeviceId(0), None, body)
    decoders: list[Any] = [remote_control.decode_reply]
    if record_type == 7500:
        decoders = [
            lambda r: remote_control.value_of(remote_control.decode_request(r)),
            lambda r: remote_control.subscribed_types(remote_control.decode_request(r)),
        ]
    for decode in decoders:
        try:
            decode(record)
        except RecordError as error:
            assert error.loss is Loss.BAD_REMOTE_CONTROL  # noqa: PT017


# setting requests


def test_what_is_wanted_is_asked_for_once_and_again_after_each_connection() -> None:
    wanted = control(range_m=100.0, gain_db=20.0)
    assert sent(wanted, 0) == [(1003, 100.0), (1008, 20.0)]
    assert sent(wanted, 60) == []  # a silent sonar is not talked at
    wanted.take(Controls(100.0, 0.0, 20.0), 61 * S)
    assert (wanted.setting_requests.state("range_m"), wanted.problems()) == (RequestState.ACCEPTED, [])
    wanted.connected()
    assert sent(wanted, 62) == [(1003, 100.0), (1008, 20.0)]


def test_nothing_wanted_leaves_the_sonar_alone() -> None:
    left = control()
    left.take(Controls(50.0), S)
    assert (sent(left, 2), left.problems()) == ([], [])


def test_a_setting_that_does_not_show_is_sent_again_a_limited_number_of_times_and_then_said() -> None:
    wanted = control(range_m=100.0)
    times = []
    for tenth in range(200):
        times += [tenth / 10 for _ in sent(wanted, tenth / 10)]
        wanted.take(Controls(50.0), tenth * S // 10)
    assert times == [0.0, 1.1, 2.2]
    assert wanted.problems() == ["the sonar did not accept range 100 m: it reports 50 m"]
    wanted.take(Controls(100.2), 30 * S)  # its own steps
    assert wanted.problems() == []


def test_of_orders_in_quick_succession_the_last_one_is_sent_and_other_settings_do_not_wait() -> None:
    wanted = control()
    asked = []
    for number in range(100):
        wanted.setting_requests.request("range_m", 10.0 + number)
        if number == 50:
            wanted.setting_requests.request("gain_db", 20.0)
        asked += [(number, *request) for request in sent(wanted, number / 100)]
    asked += [(101, *request) for request in sent(wanted, 1.01)]
    assert asked == [
        (0, 1003, 10.0), (20, 1003, 30.0), (40, 1003, 50.0), (50, 1008, 20.0), (60, 1003, 70.0), (80, 1003, 90.0),
        (101, 1003, 109.0),
    ]  # fmt: skip


def test_a_refusal_is_said_at_once_with_its_code() -> None:
    wanted = control(range_m=500.0)
    (request,) = wanted.requests(0)
    wanted.answered(ControlReply(request.ticket + 1, 9))
    assert wanted.setting_requests.state("range_m") is RequestState.PENDING
    wanted.answered(ControlReply(request.ticket, 2))
    assert wanted.problems() == ["the sonar refused range 500 m (error 2): it has not reported its settings"]
    wanted.take(Controls(100.0), 10 * S)
    assert wanted.problems() == ["the sonar refused range 500 m (error 2): it reports 100 m"]
    assert sent(wanted, 11) == []


def test_a_sonar_that_starts_afresh_behind_an_open_line_is_asked_again() -> None:
    wanted = control(range_m=50.0)
    sent(wanted, 0)
    wanted.take(Controls(50.0), S)
    wanted.take(Controls(100.0), 2 * S)
    assert sent(wanted, 2) == [(1003, 50.0)]
    assert wanted.setting_requests.counters["control_lost"] == 1


def test_pings_under_way_do_not_count_as_disobedience() -> None:
    wanted = control(range_m=100.0)
    sent(wanted, 0)
    wanted.take(Controls(100.0), S)
    wanted.setting_requests.request("range_m", 50.0)
    assert sent(wanted, 1.5) == [(1003, 50.0)]
    wanted.take(Controls(100.0), round(1.6 * S))
    assert sent(wanted, 1.7) == []
    wanted.take(Controls(50.0), round(1.8 * S))
    assert wanted.setting_requests.state("range_m") is RequestState.ACCEPTED


def test_a_value_that_is_no_number_is_not_what_was_asked_for() -> None:
    wanted = control(gain_db=20.0)
    sent(wanted, 0)
    for second in range(1, 9):
        wanted.take(Controls(100.0, 0.0, NAN), second * S)
        sent(wanted, second)
    assert wanted.problems() == ["the sonar did not accept gain 20 dB: it reports nan dB"]


def test_a_refused_subscription_is_said() -> None:
    wanted = Control({}, (7000, 7004, 7042))
    wanted.connected()
    (request,) = wanted.requests(0)
    wanted.answered(ControlReply(request.ticket, 1))
    assert wanted.problems() == ["the sonar refused to send records 7000, 7004, 7042 (error 1)"]
    wanted.connected()
    assert wanted.problems() == []


# planners


class Planners:
    def __init__(self, control: Control) -> None:
        self.answers: dict[bytes, SonarAnswer] = {}
        self.count: Counter[bytes] = Counter()
        self.requests = PlannerRequests(control.setting_requests, 4.0, self._send)

    def _send(self, peer: list[bytes], answer: SonarAnswer) -> None:
        self.answers[peer[0]] = answer
        self.count[peer[0]] += 1

    def ask(self, name: bytes, at_s: float = 0.0, **wanted: float) -> None:
        self.requests.take([name], SonarRequest(**wanted), round(at_s * S))

    def reason(self, name: bytes) -> str:
        return self.answers[name].reason


def test_a_planner_is_answered_when_the_sonar_shows_the_value() -> None:
    remote = control(range_m=100.0)
    planners = Planners(remote)
    planners.ask(b"p", range_m=50.0)
    assert sent(remote, 0) == [(1003, 50.0)]
    remote.take(Controls(100.0), S // 10)
    planners.requests.answer(S // 10)
    assert not planners.answers
    remote.take(Controls(50.0, 210.0, NAN), S // 5)
    planners.requests.answer(S // 5)
    planners.requests.answer(S)
    assert planners.answers == {b"p": SonarAnswer(ok=True, reason="", range_m=50.0, power_db=210.0)}
    assert planners.count[b"p"] == 1
    remote.connected()
    assert sent(remote, 9) == [(1003, 50.0)]  # it lasts


def test_a_planner_hears_why_not() -> None:
    remote = control()
    planners = Planners(remote)
    planners.ask(b"refused", range_m=500.0)
    (request,) = remote.requests(0)
    remote.answered(ControlReply(request.ticket, 2))
    planners.requests.answer(0)
    assert planners.reason(b"refused").startswith("the sonar refused range 500 m (error 2)")
    planners.ask(b"silence", 1.0, gain_db=10.0)
    planners.requests.answer(round(4.9 * S))
    assert b"silence" not in planners.answers
    planners.requests.answer(5 * S)
    assert planners.reason(b"silence") == "the sonar has been silent for 4 s; the request is sent when it is back"
    planners.ask(b"absurd", range_m=float("inf"))
    assert planners.reason(b"absurd") == "range_m: inf is not a number"


def test_a_wish_that_is_refused_leaves_what_was_ordered_before() -> None:
    remote = control(range_m=100.0)
    planners = Planners(remote)
    (configured,) = remote.requests(0)
    remote.take(Controls(100.0), S)
    for name, at_s in ((b"first", 2), (b"second", 3)):
        planners.ask(name, range_m=500.0, gain_db=10.0)
        asked = {request.command: request for request in remote.requests(at_s * S)}
        remote.take(Controls(100.0, NAN, 10.0), at_s * S + 1)
        remote.answered(ControlReply(asked[configured.command].ticket, 2))
        planners.requests.answer(at_s * S + 2)
        assert planners.reason(name) == "the sonar refused range 500 m (error 2): it reports 100 m"
        assert remote.problems() == []
    remote.connected()
    assert sorted(sent(remote, 9)) == [(1003, 100.0), (1008, 10.0)]


def test_a_wish_that_fails_when_nobody_waits_any_more_is_forgotten_one_that_was_fulfilled_and_lost_is_reported() -> (
    None
):
    remote = control()
    planners = Planners(remote)
    planners.ask(b"p", range_m=50.0)
    sent(remote, 0)
    planners.requests.answer(5 * S)
    assert planners.reason(b"p").startswith("the sonar has been silent")
    for at_s in range(6, 11):
        remote.take(Controls(100.0), at_s * S)
        sent(remote, at_s)
        planners.requests.answer(at_s * S)
    assert remote.problems() == []
    remote.connected()
    assert sent(remote, 11) == []

    planners.ask(b"again", 12.0, range_m=50.0)
    sent(remote, 12)
    remote.take(Controls(50.0), 13 * S)
    planners.requests.answer(13 * S)
    assert planners.reason(b"again") == ""
    for at_s in range(14, 20):
        remote.take(Controls(100.0), at_s * S)
        sent(remote, at_s)
        planners.requests.answer(at_s * S)
    assert remote.problems() == ["the sonar did not accept range 50 m: it reports 100 m"]


def test_a_later_request_replaces_an_earlier_one_for_the_same_setting_only() -> None:
    planners = Planners(control())
    planners.ask(b"range", range_m=50.0)
    planners.ask(b"gain", gain_db=10.0)
    planners.ask(b"range again", range_m=60.0)
    assert {name: a.reason for name, a in planners.answers.items()} == {b"range": "replaced by a later request"}


def test_a_request_for_nothing_asks_what_the_sonar_says() -> None:
    remote = control()
    planners = Planners(remote)
    planners.ask(b"early")
    assert planners.reason(b"early") == "the sonar has not reported its settings yet"
    remote.take(Controls(75.0, 210.0, 30.0), 0)
    planners.ask(b"late")
    assert planners.answers[b"late"] == SonarAnswer(ok=True, reason="", range_m=75.0, power_db=210.0, gain_db=30.0)


@pytest.mark.parametrize("name", ["range_m", "power_db", "gain_db"])
def test_every_knob_has_its_command(name: str) -> None:
    wanted = control(**{name: 30.0})
    commands = {"range_m": 1003, "power_db": 1005, "gain_db": 1008}
    assert sent(wanted, 0) == [(commands[name], 30.0)]
