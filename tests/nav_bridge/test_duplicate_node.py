"""Two nodes with one id on the bus: frames of two INSs, each whole or interleaved."""

import itertools
from collections.abc import Iterator

import pytest
from hypothesis import given, settings, strategies as st

from ods.base.clock import NS
from tests.nav_bridge.canopen_samples import IDS, MS, PERIOD, Bench, pdos

SAID = "two nodes send as node 5, the INS's id"


def frames(number: int, sequence: int, mark: int) -> Iterator[tuple[int, bytes]]:
    """Yield the frames of one epoch of the INS whose every field tells `mark`."""
    values = {"n": mark, "e": mark, "d": mark, "roll": mark, "u": mark, "v": mark}
    return zip(IDS, pdos(sequence, ms=43_200_000 + 10 * number, **values), strict=True)


def is_whole(bench: Bench, can_id: int, data: bytes, t_ns: int) -> bool | None:
    """Take a frame; tell whether the pose it completes is of one INS, None if it completes none."""
    pose = bench.take(can_id, data, t_ns)
    return None if pose is None else len({round(1e3 * x) for x in (*pose.position_ned, *pose.velocity_body[:2])}) == 1


@pytest.mark.parametrize("ahead", [0, 1, 2, 77, 255])
@pytest.mark.parametrize("shift_ns", [0, 100_000, 1_600_000, 5 * MS])
def test_two_nodes_with_one_id_are_noticed_and_lived_down(ahead: int, shift_ns: int) -> None:
    bench = Bench(heartbeat_timeout_s=0.0)
    poses = {"alone": 0, "both": 0, "again": 0}
    for number in range(1, 700):
        phase = "alone" if number < 100 else "both" if number < 400 else "again"
        sent = [(k * 250_000, frame) for k, frame in enumerate(frames(number, number, 1))]
        if phase == "both":
            sent += [(shift_ns + k * 250_000 + 1, frame) for k, frame in enumerate(frames(number, number + ahead, 2))]
        for delay_ns, (can_id, data) in sorted(sent):
            t_ns = number * PERIOD + delay_ns
            whole = is_whole(bench, can_id, data, t_ns)
            assert whole is not False
            poses[phase] += whole is True
        if number in (110, 399):
            assert SAID in bench.source.problems(number * PERIOD + 8 * MS)
    assert poses["alone"] == 99
    assert poses["both"] <= 5
    assert poses["again"] >= 300 - 155  # recovered 1.5 s after the last sign of the other
    assert SAID not in bench.source.problems(700 * PERIOD)
    assert bench.counters["ins_twice"] > 100


@given(st.lists(st.booleans(), min_size=300, max_size=300), st.integers(0, 3))
@settings(max_examples=60)
def test_however_two_streams_interleave_a_pose_is_never_a_mixture(turns: list[bool], ahead: int) -> None:
    bench = Bench()
    streams = [
        itertools.chain.from_iterable(frames(number, number + shift, mark) for number in range(1, 100))
        for mark, shift in ((1, 0), (2, ahead))
    ]
    for step, turn in enumerate(turns):
        can_id, data = next(streams[turn])
        assert is_whole(bench, can_id, data, NS + step * MS) is not False


def test_two_nodes_with_one_id_show_in_their_heartbeats() -> None:
    bench = Bench(heartbeat_timeout_s=0.0)
    for step, state in enumerate((5, 127) * 3):
        bench.take(0x705, bytes([state]), NS + step * 100 * MS)
    assert SAID in bench.source.problems(NS + 600 * MS)
    assert len(bench.epoch(200)) == 1  # only one of them sends PDOs
    for step in range(20):
        bench.take(0x705, b"\x05", 2 * NS + step * 100 * MS)
    assert SAID not in bench.source.problems(4 * NS)


def test_an_ins_that_starts_again_and_again_is_one() -> None:
    bench = Bench(heartbeat_timeout_s=0.0)
    for step, state in enumerate((0, 127, 5) * 6):
        bench.take(0x705, bytes([state]), NS + step * 100 * MS)
    for start in (10, 700, 0, 10, 3, 700):  # with lost epochs and numbers from the beginning
        for number in (start, start + 1, start + 3):
            bench.epoch(number)
    assert bench.counters["ins_twice"] == 0


def test_a_frame_that_was_sent_twice_is_no_second_node() -> None:
    """CAN repeats a frame whose last bit was disturbed for the sender only: receivers get it twice."""
    bench = Bench()
    poses = []
    for number in range(1, 20):
        for can_id, data in frames(number, number, 1):
            poses += [bench.take(can_id, data, number * PERIOD), bench.take(can_id, data, number * PERIOD + 1)]
    assert len([pose for pose in poses if pose]) == 19
    assert bench.counters["ins_twice"] == bench.counters["epoch_torn"] == 0
    assert bench.counters["pdo_duplicate"] + bench.counters["pdo_stray"] == 19 * 6


def test_another_node_with_our_own_id_is_said_in_plain_words() -> None:
    bench = Bench()
    bench.take(0x720, b"\x05", NS)
    assert "another node sends as node 32, our own id" in bench.source.problems(NS + MS)
    assert not any("our own id" in text for text in bench.source.problems(3 * NS))
    bench.take(0x720, b"\x05", NS, extended=True)
    assert bench.counters["own_id_taken"] == 1
