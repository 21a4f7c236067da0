"""What a long run leaves is kept on the disk, not in memory, and comes back as it was."""

import tracemalloc
from pathlib import Path

from ods.bench import spool as spool_module
from ods.bench.spool import Spool
from ods.messages import Health, ObstacleList

SPOOL = str(spool_module.__file__)


def report(seq: int) -> Health:
    counters = {f"counter_{k}": seq + k for k in range(100)}
    return Health("tracker", 7, seq, seq, seq, True, ["slow"], counters, {"ping": 6.7}, {}, {}, 1.5, 60.0)


def test_items_come_back_in_their_order(tmp_path: Path) -> None:
    lists: Spool[tuple[int, ObstacleList]] = Spool(tuple[int, ObstacleList], tmp_path)
    assert not lists
    reported = [(k, ObstacleList(k, k, 0, 0, 0, k % 2 == 0, ["late"] * k, [])) for k in range(50)]
    for each in reported:
        lists.append(each)
    assert list(lists) == reported
    assert list(reversed(lists)) == reported[::-1]
    assert (lists[-1], lists[7], lists[3:5], len(lists)) == (reported[-1], reported[7], reported[3:5], 50)
    assert not [*tmp_path.iterdir()]  # its file has no name


def test_an_hour_of_reports_takes_next_to_no_memory(tmp_path: Path) -> None:
    spool: Spool[Health] = Spool(Health, tmp_path)
    spool.append(report(0))
    tracemalloc.start()
    for seq in range(7_200):
        spool.append(report(seq))
    held = tracemalloc.take_snapshot().filter_traces([tracemalloc.Filter(True, each) for each in (__file__, SPOOL)])
    tracemalloc.stop()  # threads that other tests left behind may have memory, too
    assert sum(trace.size for trace in held.traces) < 200_000
