"""The tracker's scan steps over scenario files, timed in turns; run by its path, with the `ods` of any checkout.

Files are arguments; each line of standard input is the number of one, whose next TURN scans are tracked. The answer is
a line with their CPU times, ms, a JSON list: empty at the file's end. For `benchmarks.tracker --against`, so no more is
used of `ods` than older checkouts have.
"""

import json
import os
import sys
import time
from importlib import import_module
from importlib.util import find_spec
from itertools import islice
from pathlib import Path

TURN = 10
"""Scans of one turn: as on board, where one tracker has the caches."""


def main() -> None:
    """Answer until standard input ends."""
    # one processor for all checkouts: another one may have busier neighbours
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    _link_kernels_of_numba()
    from ods.tracker import scenario
    from ods.tracker.settings import TrackerSettings

    loaded = [scenario.load_scenario(Path(name)) for name in sys.argv[1:]]
    scans = [iter(list(scenario.scans(each))) for each in loaded]
    trackers = [scenario.tracker_for(each, TrackerSettings()) for each in loaded]
    for line in sys.stdin:
        spent_ms = []
        for scan in islice(scans[int(line)], TURN):
            began = time.process_time()
            trackers[int(line)].step(scan)
            spent_ms.append(1e3 * (time.process_time() - began))
        print(json.dumps(spent_ms), flush=True)


def _link_kernels_of_numba() -> None:
    """Let a checkout from before 0.5 take the machine code of its `ods compile`, as its processes do."""
    if find_spec("ods.compiled.kernel"):
        import_module("ods.compiled.kernel").do_without_numba()


if __name__ == "__main__":
    main()
