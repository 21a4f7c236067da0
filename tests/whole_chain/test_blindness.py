"""A sonar that pings but does not see, as processes: what the planner receives, how soon, and which objects stay."""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import msgspec
import pytest

from ods.base.clock import NS
from ods.base.settings_file import load
from ods.bench import runner
from ods.bench.settings import BenchConfig
from ods.messages import ObstacleList, UnseenWhy
from ods.offline.run_record import RunRecord
from ods.runtime.bus import BusSettings
from ods.sim_sonar.settings import Blindness, FaultSettings

CONFIG = Path(__file__).parents[2] / "config" / "bench.toml"
FAULT_S, EVERY_S, FIRST_S = 4.0, 7.0, 8.0
SAID_WITHIN = 6
"""Pings, of which there are 6.7 a second: they stand for time, as a loaded machine may be late."""
FAULTS: dict[Blindness, str] = {
    "zeros": "the sonar sends nothing (all samples are 0)",
    "head_blocked": "head blocked or out of the water",
    "saturated": "all samples are alike (255)",
    "dead_beams": "no data in 50% of the image",
    "cut_beams": "no data in 5",
}
BEGIN_S = {kind: FIRST_S + EVERY_S * k for k, kind in enumerate(FAULTS)}
HALF = ("dead_beams", "cut_beams")


@pytest.fixture(scope="module")
def record() -> Iterator[RunRecord]:
    shipped = load(CONFIG, BenchConfig)
    faults = [FaultSettings(kind, at_s, FAULT_S) for kind, at_s in BEGIN_S.items()]
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        settings = msgspec.structs.replace(
            shipped,
            bus=BusSettings(run_dir=Path(folder) / "run"),
            out=Path(folder) / "out",
            seconds=FIRST_S + EVERY_S * len(FAULTS),
            sim=msgspec.structs.replace(shipped.sim, fault=faults),
        )
        yield runner.fly_mission(settings)


def lists_between(record: RunRecord, begin_s: float, end_s: float) -> list[ObstacleList]:
    """Return the lists of pings that were sent in a span of mission time."""
    start_ns = min(truth.t_ns for truth in record.truths.values())
    sent_ns = {truth.ping_number: truth.t_ns - start_ns for truth in record.truths.values()}
    lists = [item for _, item in record.lists if item.ping_number in sent_ns]
    return [item for item in lists if begin_s * NS <= sent_ns[item.ping_number] < end_s * NS]


def says(item: ObstacleList, kind: Blindness) -> bool:
    """Tell whether a list says what is wrong, as the reason for which it is not valid or beside it."""
    return any(FAULTS[kind] in text for text in ([item.unseen_why] if kind in HALF else item.reasons))


@pytest.mark.timeout(300)
@pytest.mark.parametrize("kind", FAULTS)
def test_planner_hears_what_is_wrong_within_a_second_and_of_its_end(record: RunRecord, kind: Blindness) -> None:
    begin_s, end_s = BEGIN_S[kind], BEGIN_S[kind] + FAULT_S
    during, after = lists_between(record, begin_s, end_s), lists_between(record, end_s, end_s + EVERY_S - FAULT_S)
    parts = next(k for k, item in enumerate(during) if item.unseen)
    said = next(k for k, item in enumerate(during) if says(item, kind))
    healed = next(k for k, item in enumerate(after) if not item.unseen and not says(item, kind))
    print(f"{kind}: parts reported after {parts} pings, said after {said}, healed after {healed}")
    assert max(parts, said, healed) < SAID_WITHIN
    assert all(says(item, kind) and item.unseen_share > 0.4 for item in during[SAID_WITHIN:])
    assert {part.why for item in during for part in item.unseen} <= set(get_args(UnseenWhy))
    assert not any(item.unseen or says(item, kind) for item in after[SAID_WITHIN:])


@pytest.mark.timeout(300)
def test_dead_beams_are_reported_as_the_port_half_and_half_a_blind_sector_leaves_the_list_valid(
    record: RunRecord,
) -> None:
    begin_s = BEGIN_S["dead_beams"]
    for item in lists_between(record, begin_s, begin_s + FAULT_S)[SAID_WITHIN:]:
        assert not any("no data" in reason for reason in item.reasons)
        assert max(part.bearing_max_rad for part in item.unseen) == pytest.approx(0.0, abs=0.03)
        assert item.unseen_share == pytest.approx(0.5, abs=0.02)


@pytest.mark.timeout(300)
@pytest.mark.parametrize("kind", FAULTS)
def test_objects_keep_their_ids_and_no_others_come(record: RunRecord, kind: Blindness) -> None:
    def ids(begin_s: float, end_s: float) -> set[int]:
        return {o.id for o in lists_between(record, begin_s, end_s)[-1].obstacles if o.state == "active"}

    begin_s = BEGIN_S[kind]
    before, during = ids(begin_s - 1.0, begin_s), ids(begin_s + 1.0, begin_s + FAULT_S)
    after = ids(begin_s + FAULT_S + 1.0, begin_s + EVERY_S)
    print(f"{kind}: objects {sorted(before)}, {sorted(during)}, {sorted(after)}")
    assert before
    assert before <= during
    assert before & after == before
    assert len(during | after) <= len(before) + 1  # one may come into view
