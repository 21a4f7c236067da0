"""Results of a campaign's variants: one row each, on the terminal and as variants.csv."""

import csv
import math
from collections.abc import Mapping, Sequence
from io import StringIO
from pathlib import Path
from statistics import fmean, median
from typing import NamedTuple

from rich.table import Table

from ods.base.files.out_file import written_whole
from ods.missions.outcome import Outcome
from ods.missions.statistics import Rate, paired, rate_of

HEADERS = (
    "variant", "missions", "collisions: no avoidance", "the ODS list", "the truth as list", "only ODS / only truth",
    "p", "time-outs, ODS", "near misses, ODS", "listed", "not listed, warned", "silent",
    "least clearance, ODS / truth, m", "time, ODS / truth, s", "listed first at, m", "no valid list",
)  # fmt: skip


class Row(NamedTuple):
    """One variant."""

    name: str
    missions: int
    collisions: dict[str, Rate]
    """By arm."""
    only_ods: int
    """Worlds in which the arm `ods` collides and `truth` does not."""
    only_truth: int
    """Worlds in which the arm `truth` collides and `ods` does not."""
    p: float
    """McNemar's exact test of the two numbers."""
    time_outs: int
    """Goals that the arm `ods` did not reach in time."""
    near_misses: int
    listed: int
    """Collisions and near misses of the arm `ods` whose obstacle was listed."""
    warned: int
    """Collisions and near misses without a listed obstacle, but with a warning."""
    silent: int
    """Collisions and near misses with neither."""
    clearance_m: dict[str, float]
    """Median of the smallest clearance, by arm."""
    time_s: dict[str, float]
    """Median time, by arm."""
    first_listed_m: float | None
    """Mean distance at which obstacles are listed first."""
    not_valid_share: float


def row_of(name: str, outcomes: Sequence[Outcome]) -> Row:
    """Sum a variant up. It has the arm `ods`."""
    arms = sorted({each.arm for each in outcomes})
    own = [each for each in outcomes if each.arm == "ods"]
    bad = [each for each in own if each.ending == "collision" or each.near_miss]
    pair = next(iter(paired([each for each in outcomes if each.arm != "none"], ["ods", "truth"])))
    seen = [each.first_listed_m for each in own if each.first_listed_m is not None]
    return Row(
        name,
        len(own),
        {arm: _collisions([each for each in outcomes if each.arm == arm]) for arm in arms},
        pair.only_first_collides,
        pair.only_second_collides,
        pair.p,
        sum(each.ending == "time-out" for each in own),
        sum(each.near_miss for each in own),
        sum(each.nearest_listed for each in bad),
        sum(not each.nearest_listed and bool(each.warning) for each in bad),
        sum(not each.nearest_listed and not each.warning for each in bad),
        {arm: median(_clearances(outcomes, arm)) for arm in arms},
        {arm: median(each.time_s for each in outcomes if each.arm == arm) for arm in arms},
        fmean(seen) if seen else None,
        sum(each.not_valid_s for each in own) / sum(each.time_s for each in own),
    )


def _collisions(outcomes: Sequence[Outcome]) -> Rate:
    return rate_of(sum(each.ending == "collision" for each in outcomes), len(outcomes))


def _clearances(outcomes: Sequence[Outcome], arm: str) -> list[float]:
    own = (each.clearance_m for each in outcomes if each.arm == arm)
    return [each for each in own if each is not None] or [math.nan]


def cells_of(row: Row) -> list[str]:
    """Return a row as text, under HEADERS."""
    rates = [_rate(row.collisions[arm]) if arm in row.collisions else "-" for arm in ("none", "ods", "truth")]
    seen = "-" if row.first_listed_m is None else f"{row.first_listed_m:.1f}"
    return [row.name, str(row.missions), *rates, f"{row.only_ods} / {row.only_truth}", f"{row.p:.2g}",
            str(row.time_outs), str(row.near_misses), str(row.listed), str(row.warned), str(row.silent),
            _both(row.clearance_m), _both(row.time_s), seen,
            f"{row.not_valid_share:.1%}"]  # fmt: skip


def table_of(rows: Sequence[Row]) -> Table:
    """Return the table for the terminal."""
    table = Table(*HEADERS)
    for row in rows:
        table.add_row(*cells_of(row))
    return table


def write(rows: Sequence[Row], path: Path) -> None:
    """Write the same as CSV. Raises OSError."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEADERS)
    writer.writerows(map(cells_of, rows))
    with written_whole(path) as part:
        part.write_text(text.getvalue(), encoding="utf-8")


def _both(values: Mapping[str, float]) -> str:
    return f"{values['ods']:.1f} / {values['truth']:.1f}"


def _rate(rate: Rate) -> str:
    return f"{rate.count} ({100 * rate.low:.0f} to {100 * rate.high:.0f} %)"
