"""Agreement of missions by drawn detections with those by images: figures side by side, with their intervals."""

import math
from collections.abc import Callable, Iterable, Sequence
from statistics import fmean, stdev
from typing import NamedTuple

from rich.table import Table

from ods.missions.outcome import Outcome
from ods.missions.statistics import rate_of

SIGMAS = 1.96
"""Of a mean, for 95 %."""


class Interval(NamedTuple):
    """A figure and its 95 % interval."""

    value: float
    low: float
    high: float


class Compared(NamedTuple):
    """A figure by both fidelities."""

    name: str
    images: Interval
    detections: Interval
    scale: float
    """By which it is shown."""

    @property
    def agree(self) -> bool:
        """The intervals overlap."""
        return self.images.low <= self.detections.high and self.detections.low <= self.images.high


def compared(images: Sequence[Outcome], detections: Sequence[Outcome]) -> list[Compared]:
    """Return the figures of two runs of the same worlds, of at least two missions each."""
    rates: dict[str, Callable[[Outcome], bool]] = {
        "success, %": lambda each: each.ending == "success",
        "collision, %": lambda each: each.ending == "collision",
        "near miss, %": lambda each: each.near_miss,
    }
    means: dict[str, Callable[[Outcome], float | None]] = {
        "first listed at, m": lambda each: each.first_listed_m,
        "obstacles listed": lambda each: each.listed,
        "least clearance, m": lambda each: each.clearance_m,
        "evasions": lambda each: each.evasions,
        "evasions without an obstacle": lambda each: each.evasions_of_nothing,
    }
    rows = [
        Compared(name, _share(map(happened, images)), _share(map(happened, detections)), 100.0)
        for name, happened in rates.items()
    ]
    for name, figure in means.items():
        rows.append(Compared(name, _mean(map(figure, images)), _mean(map(figure, detections)), 1.0))
    return rows


def table_of(rows: Sequence[Compared], missions: int) -> Table:
    """Return them side by side."""
    table = Table(f"{missions} missions", "images", "detections", "intervals overlap")
    for row in rows:
        cells = [
            f"{row.scale * each.value:.1f} ({row.scale * each.low:.1f} to {row.scale * each.high:.1f})"
            for each in (row.images, row.detections)
        ]
        table.add_row(row.name, *cells, "yes" if row.agree else "no")
    return table


def _share(happened: Iterable[bool]) -> Interval:
    every = list(happened)
    rate = rate_of(sum(every), len(every))
    return Interval(rate.share, rate.low, rate.high)


def _mean(values: Iterable[float | None]) -> Interval:
    known = [value for value in values if value is not None]
    if len(known) < 2:
        return Interval(math.nan, -math.inf, math.inf)
    middle, half = fmean(known), SIGMAS * stdev(known) / math.sqrt(len(known))
    return Interval(middle, middle - half, middle + half)
