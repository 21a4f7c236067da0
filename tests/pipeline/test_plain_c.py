"""The chain in plain C that ours is measured beside."""

from collections.abc import Iterator

import numpy as np
import pytest

from benchmarks.c_chain.frames import made_up_ping
from benchmarks.c_chain.networks import RUNS, WINDOW, Cell, Step, median_of_window, sorted_run
from benchmarks.c_chain.plain_c import FILTERS, PlainC, built
from ods.base.arrays import Floats


def results(step: Step, runs: dict[int, Floats], count: int) -> Floats:
    """Return the results at `count` places; runs: (members, places) of each length."""
    values: dict[int, Floats] = {}
    for number, what, of in step.operations:
        if isinstance(what, Cell):
            values[number] = runs[what.run][what.member, what.shift : what.shift + count]
        else:
            values[number] = (np.minimum if what == "min" else np.maximum)(values[of[0]], values[of[1]])
    return np.array([values[result] for result in step.results if result is not None])


def test_the_network_finds_the_median_of_each_window() -> None:
    cells = np.random.default_rng(1).integers(0, 12, 400).astype(np.float64)
    runs = {1: cells[None]}
    for length in RUNS:
        runs[length] = results(sorted_run(length), runs, cells.size - length + 1)
    found = results(median_of_window(), runs, cells.size - WINDOW + 1)[0]
    np.testing.assert_array_equal(found, np.median(np.lib.stride_tricks.sliding_window_view(cells, WINDOW), axis=1))


@pytest.fixture(scope="module")
def plain() -> Iterator[PlainC]:
    with built() as chain:
        yield chain


@pytest.mark.parametrize("name", ["FIR 9", "median 9"])
@pytest.mark.parametrize("bits", [8, 16])
def test_it_finds_the_objects_of_a_made_up_frame(plain: PlainC, name: str, bits: int) -> None:
    assert name in FILTERS
    assert 6 <= plain.task(made_up_ping(60, 2000, bits, 2), name)() <= 14
