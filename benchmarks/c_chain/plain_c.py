"""The chain of sonar.c, compiled for this processor."""

import ctypes
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.c_chain.networks import WINDOW
from benchmarks.c_chain.rows import rows_h
from ods.base.arrays import AnyArray
from ods.messages import Ping, frame_of

SOURCE = Path(__file__).with_name("sonar.c")
FLAGS = [
    "-O3", "-ffast-math", "-march=native", "-mprefer-vector-width=512", "-fPIC", "-fvisibility=hidden",
    "-Wall", "-Wextra",
]  # fmt: skip
FILTERS = {"FIR 9": 0, "Wiener 9": 1, "median 9": 2}
"""Numbers that sonar.c gives them."""
LEVELS = {"FIR 9": (1.75, 2.4), "Wiener 9": (2.4, 3.4), "median 9": (1.85, 2.5)}
"""Low and high one, in multiples of the mean of each range."""
MOST = 4096
"""Detections."""
DETECTION_BYTES = 28


class Job(ctypes.Structure):
    """`Job` of sonar.c."""

    _fields_ = [
        ("frame", ctypes.c_void_p),
        *((name, ctypes.c_int64) for name in ("bits", "beams", "columns", "filter")),
        *((name, ctypes.c_void_p) for name in ("taps", "equalized", "filtered", "variance")),
        *((name, ctypes.c_double) for name in ("low", "high", "first_rad", "spacing_rad", "range0_m", "dr_m")),
    ]


class PlainC:
    """Detects by it."""

    def __init__(self, library: ctypes.CDLL) -> None:
        self._detections: Callable[..., int] = library.detections
        library.detections.argtypes = [ctypes.POINTER(Job), ctypes.c_void_p, ctypes.c_int]
        self._found = np.zeros(MOST * DETECTION_BYTES, np.uint8)
        taps = np.hanning(WINDOW + 2)[1:-1]
        self._taps = (taps / taps.sum()).astype(np.float32)

    def task(self, ping: Ping, name: str) -> Callable[[], int]:
        """Return what makes detections of a ping by a filter of FILTERS, and tells how many there are."""
        frame = np.ascontiguousarray(frame_of(ping))
        work = [np.empty(frame.shape, np.float32) for _ in range(3)]
        bearing, (low, high) = ping.bearing_rad, LEVELS[name]
        job = Job(
            _address(frame), 8 * frame.itemsize, *frame.shape, FILTERS[name], *map(_address, [self._taps, *work]),
            low, high, bearing[0], bearing[1] - bearing[0], ping.range0_m, ping.dr_m,
        )  # fmt: skip
        return partial(self._run, job, frame, *work)

    def _run(self, job: Job, *_: AnyArray) -> int:
        """Return how many detections there are; _: arrays that the job points to, which have to be kept."""
        return self._detections(job, _address(self._found), MOST)


@contextmanager
def built() -> Iterator[PlainC]:
    """Compile it for a while."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "rows.h").write_text(rows_h(), encoding="utf-8")
        compiled, library = f"{folder}/sonar.o", f"{folder}/sonar.so"
        subprocess.run(["gcc", *FLAGS, f"-I{folder}", "-c", str(SOURCE), "-o", compiled], check=True)
        # linked without -ffast-math, which would have the whole process round small numbers to 0
        subprocess.run(["gcc", "-shared", compiled, "-o", library, "-lm"], check=True)
        yield PlainC(ctypes.CDLL(library))


def _address(array: AnyArray) -> int:
    address: int = array.ctypes.data
    return address
