"""The counter table: nothing is counted that has no row, no row is never counted, and doctor and EDS know its names."""

from pathlib import Path

import pytest
from canopen.objectdictionary import ODArray

import ods
from ods.nav_bridge.canopen.eds import read_dictionary
from ods.runtime import counters
from ods.runtime.counters import COUNTERS
from ods.runtime.processes import PROCESSES
from ods.runtime.service import Service
from tests.runtime.counted_names import Counted, all_counted, counted_in

SOURCES = Path(ods.__file__).parent
TABLE = Path(counters.__file__)
NOT_COUNTED = {"ods/sonar_link/oculus/framer.py: no_sync"}
"""The framer asks only where a sync word stands."""
NAMES = {name for rows in COUNTERS.values() for name in rows}


@pytest.fixture(scope="module")
def everywhere() -> dict[str, Counted]:
    """Return what each module counts."""
    return all_counted(SOURCES, without=[TABLE])


def test_every_name_that_is_counted_has_a_row(everywhere: dict[str, Counted]) -> None:
    unknown = {f"{module}: {name}" for module, counted in everywhere.items() for name in counted.names - NAMES}
    assert unknown <= NOT_COUNTED, f"counted without a row in {TABLE.name}"


def test_every_text_with_a_gap_that_is_counted_has_rows(everywhere: dict[str, Counted]) -> None:
    for module, counted in everywhere.items():
        for pattern in counted.patterns:
            assert any(counted.matches(name) for name in NAMES), f"{module}: {pattern}"


def test_every_row_is_counted_somewhere(everywhere: dict[str, Counted]) -> None:
    idle = {name for name in NAMES if not any(counted.matches(name) for counted in everywhere.values())}
    assert not idle, f"rows of {TABLE.name} that nobody counts"


def test_every_process_has_rows_for_its_sockets() -> None:
    assert COUNTERS.keys() >= PROCESSES.keys()
    assert "dropped_ping" in COUNTERS["pipeline"]
    assert "dropped_health" in COUNTERS["tracker"]
    assert "bad_sonar-requests" in COUNTERS["sonar"]


@pytest.mark.parametrize(
    "source",
    [
        'self._counters["a_name"] += 1',
        'losses["a_name" if bad else "b"] += 1',
        'own = RecentEvent("a_name", counters)',
        'raise RecordError("a_name")',
        "class Loss(Enum):\n    A = 'a_name'",
        "Counter(a_name=3)",
        'service.log_once("a_name", f"{x} is bad")',
        'def why():\n    return "a_name"\ndef f():\n    counters[why()] += 1',
    ],
)
def test_a_name_is_found_however_it_comes_to_be_counted(source: str) -> None:
    assert "a_name" in counted_in(source).names


def test_texts_that_are_not_counted_are_left_alone() -> None:
    assert not counted_in('options["a_name"]; send("a_name"); raise ValueError("not a name")').names


def test_the_own_node_serves_no_counter_without_a_row() -> None:
    served = read_dictionary(Path("config/ods_node.eds"), 32, "nav.canopen.node_eds")[0x2000]
    assert isinstance(served, ODArray)
    names = {item.name for item in served.subindices.values() if item.subindex}
    assert len(names) > 30
    assert names <= COUNTERS["nav"].keys()


def test_tests_refuse_a_name_without_a_row() -> None:
    counters.refuse_unknown("nav", ["poses"])
    with pytest.raises(LookupError, match="pozes"):
        counters.refuse_unknown("nav", ["poses", "pozes"])


def test_a_vehicle_does_not_stop_for_a_name_without_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(counters.REFUSE)
    counters.refuse_unknown("nav", ["pozes"])


def test_a_running_service_refuses_a_name_without_a_row(tmp_path: Path) -> None:
    service = Service(PROCESSES["nav"], tmp_path)
    try:
        service.counters["poses"] += 1
        service.report_health(ready=True, problems=[])
        service.counters["pozes"] += 1
        with pytest.raises(LookupError, match="nav counts pozes"):
            service.report_health(ready=True, problems=[])
    finally:
        service.close()
