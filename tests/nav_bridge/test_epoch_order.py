"""Which frames are of one instant, found on the bus: against an INS made by hand, whose truth is known."""

import itertools
from collections import Counter
from random import Random

import pytest
from hypothesis import given, settings as examples, strategies as st

from ods.base.geodesy import LocalFrame
from ods.messages import Pose
from ods.nav_bridge.can.frame import Frame
from ods.nav_bridge.dbc.source import DbcSource
from ods.nav_bridge.settings import DbcSettings, NavSettings
from ods.nav_bridge.source import SourceHost
from tests.nav_bridge.handmade_ins import IDS, MS, NS, Manner, frames, number_of, settings
from tests.nav_bridge.made_up_clock import utc_ahead

ORDERS = list(itertools.permutations(IDS))
CLOCK_FIRST = ("CLOCK", "PLACE", "DEPTH", "TURN", "SPEED")
"""The clock has the highest identifier, and PLACE the lowest."""


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> DbcSettings:
    return settings(tmp_path_factory.mktemp("dbc"), window_s=0.004)


def changed(reported: DbcSettings, **changes: object) -> DbcSettings:
    return DbcSettings(**({name: getattr(reported, name) for name in reported.__struct_fields__} | changes))


class Run:
    """What became of an INS's frames. No pose is of two instants, or the run fails."""

    def __init__(self, dbc: DbcSettings, manner: Manner, instants: int = 40, seed: int = 0) -> None:
        self.counters: Counter[str] = Counter()
        host = SourceHost(LocalFrame(57.0, 9.9), lambda *_: None, self.counters, 0, utc_ahead(0))
        source = DbcSource(NavSettings(source="dbc", dbc=dbc, stale_s=0.1), dbc, host)
        self.numbers: list[int] = []
        arrived = sorted(frames(manner, instants, Random(seed)))
        for sent in arrived:
            pose = source.take(Frame(sent.can_id, False, sent.data, sent.t_ns))
            if pose is not None:
                self.numbers.append(self.check(pose, manner))
        self.problems = source.problems(arrived[-1].t_ns)

    @staticmethod
    def check(pose: Pose, manner: Manner) -> int:
        """Assert that the pose's time, too, is that of its instant: no other is nearer; return the instant."""
        number = number_of(pose)
        late_ns = pose.t_ns - 2 * MS - number * NS / manner.rate_hz
        assert -MS < late_ns < 0.5 * NS / manner.rate_hz + manner.jitter_ns + MS
        return number


def test_frames_in_every_order_become_poses_of_one_instant(reported: DbcSettings) -> None:
    for order in ORDERS:
        assert Run(reported, Manner(order), 20).numbers == list(range(9, 20)), order


@pytest.mark.parametrize("rate_hz", [10.0, 50.0, 200.0])
def test_at_every_rate(reported: DbcSettings, rate_hz: float) -> None:
    assert Run(reported, Manner(CLOCK_FIRST, rate_hz), 20).numbers == list(range(9, 20))


@given(
    st.sampled_from(ORDERS),
    st.sampled_from([10.0, 25.0, 100.0, 200.0]),
    st.sampled_from([0, 100_000, 400_000]),
    st.floats(0.0, 0.3),
    st.floats(0.0, 0.15),
    st.integers(0, 2**32 - 1),
)
@examples(max_examples=150, deadline=None)
def test_jitter_delays_and_losses_cost_poses_but_mix_none(
    reported: DbcSettings,
    order: tuple[str, ...],
    rate_hz: float,
    jitter_ns: int,
    delayed: float,
    lost: float,
    seed: int,
) -> None:
    run = Run(reported, Manner(order, rate_hz, 250_000, jitter_ns, delayed, lost), 60, seed)
    if not jitter_ns and delayed < 0.05 and lost < 0.02:
        assert len(run.numbers) > 20


@given(st.sampled_from(ORDERS), st.integers(1, 4), st.floats(0.0, 0.2), st.integers(0, 2**32 - 1))
@examples(max_examples=60, deadline=None)
def test_an_order_reported_wrongly_gives_no_pose_and_is_said(
    reported: DbcSettings, order: tuple[str, ...], turned: int, delayed: float, seed: int
) -> None:
    wrong = changed(reported, epoch=[*order[turned:], *order[:turned]])
    run = Run(wrong, Manner(order, delayed=delayed), 60, seed)
    assert run.numbers == []
    if not delayed:
        assert f"epochs are paired wrongly by nav.dbc.epoch: on the bus an instant's messages come as {order[0]} (" in (
            "".join(run.problems)
        )


def test_frames_spread_evenly_are_refused_until_their_order_is_reported(reported: DbcSettings) -> None:
    spread = Manner(CLOCK_FIRST, frame_ns=2 * MS - 1)
    run = Run(reported, spread)
    assert run.numbers == []
    assert "the first message of an instant cannot be found, because the longest silences" in run.problems[1]
    wide = changed(reported, window_s=0.0095, epoch=list(CLOCK_FIRST))
    assert Run(wide, spread).numbers == list(range(9, 40))


@pytest.mark.parametrize("seed", range(5))
def test_a_number_that_all_share_pairs_them_where_gaps_cannot(reported: DbcSettings, seed: int) -> None:
    counted = changed(reported, window_s=0.0099, sequence=[f"{name}.COUNT" for name in IDS])
    order = Random(seed).sample(CLOCK_FIRST, 5)
    assert Run(counted, Manner(order, frame_ns=2 * MS - 1), 300).numbers == list(range(300))
    assert len(Run(counted, Manner(order, lost=0.1, jitter_ns=400_000), 600, seed).numbers) > 200


def test_messages_in_changing_order_or_rate_are_distinguished(reported: DbcSettings) -> None:
    rare = Run(reported, Manner((*CLOCK_FIRST, *CLOCK_FIRST[:4])))
    assert "SPEED (0x400): more rarely than the others: " in rare.problems[1]
    changing = Run(reported, Manner((*CLOCK_FIRST, "SPEED", "TURN", "PLACE", "CLOCK", "DEPTH")))
    assert "come in changing order: nav.dbc.sequence must name" in changing.problems[1]


def test_an_ins_that_is_set_to_another_order_while_running_is_followed(reported: DbcSettings) -> None:
    counters: Counter[str] = Counter()
    host = SourceHost(LocalFrame(57.0, 9.9), lambda *_: None, counters, 0, utc_ahead(0))
    source = DbcSource(NavSettings(source="dbc", dbc=reported), reported, host)
    numbers = []
    for order, numbers_now in ((CLOCK_FIRST, range(30)), ((*CLOCK_FIRST[2:], *CLOCK_FIRST[:2]), range(30, 70))):
        for sent in frames(Manner(order), 70, Random(0)):
            if sent.t_ns // (10 * MS) in numbers_now:
                pose = source.take(Frame(sent.can_id, False, sent.data, sent.t_ns))
                numbers += [] if pose is None else [Run.check(pose, Manner(order))]
    assert numbers[:21] == list(range(9, 30))
    assert numbers[21:] == list(range(numbers[21], 70))
    assert numbers[21] < 50


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"sequence": ["CLOCK.COUNT"]}, "nav.dbc.sequence: must have a signal of PLACE, DEPTH, TURN, SPEED too"),
        ({"sequence": ["CLOCK.NUMBER"]}, "nav.dbc.sequence: message CLOCK has no signal 'NUMBER'"),
    ],
)
def test_a_sequence_that_does_not_fit_is_one_line(reported: DbcSettings, changes: dict[str, object], said: str) -> None:
    with pytest.raises(Exception, match=said):
        Run(changed(reported, **changes), Manner())
