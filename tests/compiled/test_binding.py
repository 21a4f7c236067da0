"""How kernels are called: what does not fit is refused in words, before anything is read or written."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ods.compiled import native

SOURCES = Path(__file__).parents[2] / "ods"
IMAGE = np.ones((4, 32), np.float32)


def blend(image: object, share: object, mean: object) -> None:
    """Call a kernel that takes an image, a number and an image that it writes to."""
    native.blend(image, share, mean)


def test_a_kernel_computes_in_place() -> None:
    mean = np.zeros_like(IMAGE)
    blend(IMAGE, 0.25, mean)
    assert (mean == 0.25).all()


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ((IMAGE.astype(np.float64), 0.5, IMAGE.copy()), "another type of elements"),
        ((IMAGE[0], 0.5, IMAGE.copy()), "another number of dimensions"),
        ((IMAGE, 0.5, IMAGE[:3].copy()), "another size"),
        ((IMAGE[:, ::2], 0.5, IMAGE[:, ::2].copy()), "not C-contiguous"),
        ((IMAGE.astype(">f4"), 0.5, IMAGE.copy()), "another type of elements"),
        ((IMAGE.tolist(), 0.5, IMAGE.copy()), "must be an array"),
        ((IMAGE, 0.5), "too few arguments"),
        ((IMAGE, 0.5, IMAGE.copy(), 1), "too many arguments"),
    ],
)
def test_what_does_not_fit_is_refused(arguments: tuple[object, ...], why: str) -> None:
    with pytest.raises(TypeError, match=why):
        native.blend(*arguments)


def test_what_may_not_be_written_is_not() -> None:
    mean = IMAGE.copy()
    mean.flags.writeable = False
    with pytest.raises(TypeError, match="cannot be written to"):
        blend(IMAGE, 0.5, mean)


def test_a_number_that_is_none_is_an_error() -> None:
    with pytest.raises(TypeError):
        blend(IMAGE, "0.5", IMAGE.copy())


def test_a_tuple_stands_for_several_arguments() -> None:
    mean = np.zeros_like(IMAGE)
    native.blend((IMAGE, (0.5, mean)))
    assert (mean == 0.5).all()


def test_every_kernel_declared_in_c_can_be_called_and_is() -> None:
    """A kernel that no Python calls is to be deleted; one that is misspelt is found before its first call."""
    declared, called = set[str](), set[str]()
    for source in SOURCES.rglob("*.c"):
        declared |= set(re.findall(r"^(?:LONG_)?KERNEL(?:_\w+)?\(\s*(\w+),", source.read_text(), re.M))
    for source in SOURCES.rglob("*.py"):
        called |= set(re.findall(r"\bnative\.(\w+)", source.read_text()))
    assert declared == {name for name in dir(native) if not name.startswith("_")}
    assert called == declared


SCRATCH = """
from pathlib import Path
import numpy as np
from ods.compiled import native

def resident_mb():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6

image = np.random.default_rng(0).rayleigh(1.0, (512, 20_000)).astype(np.float32)
found = np.zeros(1)
before = resident_mb()
for _ in range(20):
    native.noise_quantiles(image, 1, np.array([0.5]), found)
print(resident_mb() - before)
"""


def test_scratch_memory_is_given_back() -> None:
    """Each call works on a copy of the image's 40 MB."""
    reported = subprocess.run([sys.executable, "-c", SCRATCH], capture_output=True, text=True, check=True).stdout
    assert float(reported) < 10.0
