"""A recording of ten minutes in the workbench: opened, and its pings with their poses in any order.

Part of `python -m benchmarks.workbench`.
"""

import random
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.workbench import scrub
from benchmarks.workbench.beside import SAMPLES, recording
from ods.workbench.engine.data import Data, open_data
from ods.workbench.engine.ping.analysis import POSES_BEFORE
from ods.workbench.model.state import DataReference

PINGS, BEAMS = 4200, 60
"""Ten minutes at 7 images/s."""
LOOKED_AT = 200


def tell() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        whole = recording(Path(name) / "whole.mcap", BEAMS, PINGS)
        torn = Path(name) / "torn.mcap"
        torn.write_bytes(whole.read_bytes()[: whole.stat().st_size * 9 // 10])
        megabytes = whole.stat().st_size / 1e6
        print(f"\nRecording of {PINGS} pings of {BEAMS} x {SAMPLES} samples, 15 poses a ping, {megabytes:.0f} MB:\n")
        print("| file | open, ms CPU | open, ms | ping and pose, on, ms | anywhere, ms |\n|---|---|---|---|---|")
        for path in (whole, torn):
            began, cpu = time.perf_counter(), time.process_time()
            data = open_data(DataReference(kind="file", path=str(path)), None, [path.parent])
            data.pings[0]
            opened = [1e3 * (now - then) for now, then in ((time.process_time(), cpu), (time.perf_counter(), began))]
            places = random.Random(1).sample(range(len(data.pings)), LOOKED_AT)
            taken = [_ms_each(data, order) for order in (range(LOOKED_AT), places)]
            print(f"| {path.stem} | {' | '.join(f'{ms:.1f}' for ms in (*opened, *taken))} |", flush=True)
        scrub.tell(whole)


def _ms_each(data: Data, places: Sequence[int]) -> float:
    began = time.perf_counter()
    for place in places:
        data.poses_about(data.pings[place].t_ns, POSES_BEFORE)
    return 1e3 * (time.perf_counter() - began) / len(places)
