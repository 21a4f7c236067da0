"""`python -m benchmarks.processes.export`: what exporting a recording takes, and what comes out.

A made-up recording: speckle of 60 x 2000 samples, 8 bits, logarithmic, 7 pings a second; 105 poses, 20 detections and
20 obstacles a ping, five processes' health. Reading and decoding the recording is in each time.
"""

import argparse
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np

from ods.base.clock import NS
from ods.base.frames.mounting import AT_ORIGIN
from ods.base.geodesy import LocalFrame
from ods.export.command import FORMATS, maker
from ods.export.conversion import TOPICS, export
from ods.export.place import Place
from ods.messages import ClosestApproach, Detection, Detections, Health, Obstacle, ObstacleList, Ping, Pose, Sector
from ods.recording.mcap.reader import open_recording
from ods.recording.mcap.segment import Logged, Segment

BEAMS, SAMPLES, OBJECTS, POSES_A_PING = 60, 2000, 20, 15
OFFSET_NS = 1_700_000_000 * NS
PLACE = Place(LocalFrame(57.0, 10.0), AT_ORIGIN)


def main() -> None:
    """Print the figures of docs/recordings/export.md."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--pings", type=int, default=200)
    parser.add_argument("--times", type=int, default=3, help="each format is written so often; the median counts")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        size = record(folder / "a.mcap", args.pings)
        print(f"{args.pings} pings, recording of {size / 1e3 / args.pings:.1f} kB a ping\n")
        print("| format | CPU ms a ping | kB a ping | of the recording |\n|---|---|---|---|")
        for form in FORMATS:
            taken, made = zip(*(written(folder, form) for _ in range(args.times)), strict=True)
            ms, kb = np.median(taken) * 1e3 / args.pings, made[0] / 1e3 / args.pings
            print(f"| `--{form}` | {ms:.2f} | {kb:.1f} | {made[0] / size:.0%} |")


def record(path: Path, pings: int) -> int:
    """Write the recording; return its size."""
    segment = Segment(path, OFFSET_NS, {"ods": {"utc_offset_ns": str(OFFSET_NS)}})
    rng = np.random.default_rng(1)
    for number in range(pings):
        t_ns = NS + number * NS // 7
        for topic, message in cycle(number, t_ns, rng):
            segment.write([Logged(topic, t_ns + OFFSET_NS, msgspec.msgpack.encode(message))])
        segment.close_chunk()
    segment.finish()
    return path.stat().st_size


def cycle(number: int, t_ns: int, rng: np.random.Generator) -> Iterator[tuple[str, msgspec.Struct]]:
    """Yield what the chain publishes around one ping."""
    utc_ns = t_ns + OFFSET_NS
    for seq in range(number * POSES_A_PING, (number + 1) * POSES_A_PING):
        north, east, down = (100.0 + 0.01 * seq + rng.normal(0.0, 0.01, 3)).tolist()
        turn = (1.0, *rng.normal(0.0, 0.01, 3).tolist())
        yield "pose", Pose(seq, t_ns, utc_ns, (north, east, down), turn, (1.5, 0.0, 0.0), (0.1,) * 3, (0.01,) * 3)
    counts = np.clip(40.0 * np.log10(30.0 * rng.rayleigh(size=(BEAMS, SAMPLES)) + 1.0), 0, 255).astype(np.uint8)
    yield "ping", Ping(
        number, number, t_ns, t_ns, utc_ns, BEAMS, SAMPLES, "u1", counts.tobytes(),
        np.radians(np.linspace(-44.0, 44.0, BEAMS)).tolist(), 0.5, 0.025, 1490.0, scale="log8", scale_factor=40.0,
    )  # fmt: skip
    numbers = rng.normal(10.0, 1.0, (OBJECTS, 12)).tolist()
    found = [detection(row) for row in numbers]
    yield "detections", Detections(number, number, t_ns, t_ns, utc_ns, 1490.0, Sector(1, 50, -1, 1, 0.1), found)
    there = [obstacle(each, row, utc_ns) for each, row in enumerate(numbers)]
    yield "obstacles", ObstacleList(number, number, t_ns, utc_ns, t_ns, True, [], there)
    for process in ("nav", "sonar", "pipeline", "tracker", "run")[: 5 if number % 3 == 0 else 0]:
        counters = {f"counter_{n}": n for n in range(20)}
        yield "health", Health(process, 1, number, t_ns, utc_ns, True, [], counters, {}, {}, {}, 3.0, 50.0)


def detection(row: list[float]) -> Detection:
    """Return one of a ping."""
    return Detection(row[0], row[1], row[2], row[3], row[4], row[5], 20, row[6], row[7], row[8], row[9], row[10])


def obstacle(number: int, row: list[float], utc_ns: int) -> Obstacle:
    """Return one of a list."""
    place, speed, sigma = (row[0], row[1], row[2]), (row[3], row[4], 0.0), (0.3, 0.4, 3.0)
    nearest = ClosestApproach(row[5], row[6], 0.3)
    return Obstacle(
        number, "active", place, speed, 1.0, sigma, sigma, 0.1, utc_ns, utc_ns, 9, 0.9, covariance_ne=0.01, cpa=nearest
    )


def written(folder: Path, form: str) -> tuple[float, int]:
    """Export; return CPU time, s, and the size of what came out, bytes."""
    out = folder / f"{form}-{time.monotonic_ns()}"
    begun = time.process_time()
    export(open_recording(folder / "a.mcap").messages(TOPICS), out, maker(form, PLACE))
    taken = time.process_time() - begun
    return taken, sum(path.stat().st_size for path in (out.iterdir() if out.is_dir() else [out]))


if __name__ == "__main__":
    main()
