"""Networks of comparisons that find a sliding median, sharing what neighbouring windows have in common.

A window of nine is two sorted runs of four and one cell more. A run of four that begins at cell j is merged of two of
two, at j and j + 2, and each serves all windows that it lies in. Sorted runs are merged by odd-even merging (K. E.
Batcher, AFIPS Spring Joint Computer Conf., 1968); what the median does not depend on is left out.
"""

from typing import Literal, NamedTuple

WINDOW = 9
RUNS = 2, 4
"""Lengths of the sorted runs that are kept."""

Value = int | None
"""Number of an operation's result; None: infinity."""


class Cell(NamedTuple):
    """What a network starts from: a member of a sorted run (of length 1: a cell), so many cells on."""

    run: int
    member: int
    shift: int


class Operation(NamedTuple):
    """One comparison, or a cell that is read."""

    result: int
    what: Literal["min", "max"] | Cell
    of: tuple[int, int]
    """Operands; none of a cell."""


class Network:
    """Comparisons in the order in which they are made, each but once."""

    def __init__(self) -> None:
        self._operations: list[Operation] = []
        self._known: dict[tuple[object, ...], int] = {}

    def read(self, run: int, shift: int) -> list[Value]:
        """Return the members of a sorted run."""
        return [self._result(Cell(run, member, shift), (-1, -1)) for member in range(run)]

    def merged(self, a: list[Value], b: list[Value]) -> list[Value]:
        """Return two sorted runs as one."""
        size = 1
        while size < max(len(a), len(b)):
            size *= 2
        full = self._odd_even(a + [None] * (size - len(a)), b + [None] * (size - len(b)))
        return full[: len(a) + len(b)]

    def ranked(self, a: list[Value], b: list[Value], rank: int) -> Value:
        """Return the value of two sorted runs that `rank` others are not larger than.

        The least of what the rank + 1 smallest, so many of them from a, would have as their largest.
        """
        least: Value = None
        for i in range(-1, rank + 1):
            j = rank - 1 - i
            if i < len(a) and j < len(b):
                largest = b[j] if i < 0 else a[i] if j < 0 else self._larger(a[i], b[j])
                least = self._smaller(least, largest)
        return least

    def needed(self, results: list[Value]) -> list[Operation]:
        """Return the operations that these results depend on."""
        wanted, kept = set(results), []
        for operation in reversed(self._operations):
            if operation.result in wanted:
                kept.append(operation)
                wanted.update(operation.of)
        return kept[::-1]

    def _odd_even(self, a: list[Value], b: list[Value]) -> list[Value]:
        if len(a) == 1:
            return [self._smaller(a[0], b[0]), self._larger(a[0], b[0])]
        even, odd = self._odd_even(a[::2], b[::2]), self._odd_even(a[1::2], b[1::2])
        out = even[:1]
        for x, y in zip(odd[:-1], even[1:], strict=True):
            out += [self._smaller(x, y), self._larger(x, y)]
        return [*out, odd[-1]]

    def _smaller(self, a: Value, b: Value) -> Value:
        if a is None or b is None:
            return b if a is None else a
        return self._result("min", (min(a, b), max(a, b)))

    def _larger(self, a: Value, b: Value) -> Value:
        return None if a is None or b is None else self._result("max", (min(a, b), max(a, b)))

    def _result(self, what: Literal["min", "max"] | Cell, of: tuple[int, int]) -> int:
        number = self._known.setdefault((what, of), len(self._operations))
        if number == len(self._operations):
            self._operations.append(Operation(number, what, of))
        return number


class Step(NamedTuple):
    """Operations, and those of their results that are wanted."""

    operations: list[Operation]
    results: list[Value]


def sorted_run(length: int) -> Step:
    """Return how a sorted run is made of two of half its length."""
    network, half = Network(), length // 2
    results = network.merged(network.read(half, 0), network.read(half, half))
    return Step(network.needed(results), results)


def median_of_window() -> Step:
    """Return how the median is found of two runs of four and a cell."""
    network = Network()
    five = network.merged(network.read(1, 8), network.read(4, 0))
    results = [network.ranked(network.read(4, 4), five, WINDOW // 2)]
    return Step(network.needed(results), results)
