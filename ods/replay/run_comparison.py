"""`ods replay --check --config OTHER.toml`: what would have been, object by object."""

from collections import Counter
from dataclasses import dataclass, field
from itertools import islice

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.optimize import linear_sum_assignment

from ods.base.clock import NS
from ods.config import OnboardConfig
from ods.messages import Obstacle, ObstacleList
from ods.recording.mcap.reader import Recording
from ods.replay.check import shown
from ods.replay.rerun import ListPair, PipelineRerun, TrackerRerun

SAME_M = 5.0
"""Two obstacles farther apart are not of one object, as on the bench."""
FAR = 1e6
MOST_ROWS = 200


@dataclass
class Sighting:
    """One object of one of both runs."""

    first_ns: int
    """`t_ns` of the first list that has it."""
    lists: int = 0
    partners: "Counter[int]" = field(default_factory=Counter)
    """Ids of the other run that stood for the same object, and in how many lists."""
    apart_m: list[float] = field(default_factory=list)


class Differences:
    """Compares two runs list by list."""

    def __init__(self) -> None:
        self.begin_ns: int | None = None
        self.recorded: dict[int, Sighting] = {}
        self.now: dict[int, Sighting] = {}
        self.lists = 0

    def add(self, pair: ListPair) -> None:
        """Take both lists of one instant."""
        original, again = pair.recorded, pair.again
        self.begin_ns = original.t_ns if self.begin_ns is None else self.begin_ns
        self.lists += 1
        here = _noted(self.recorded, original)
        there = _noted(self.now, again) if again is not None else []
        for a, b, apart in _pairs(here, there):
            self.recorded[a].partners[b] += 1
            self.recorded[a].apart_m.append(apart)
            self.now[b].partners[a] += 1

    def rows(self) -> list[tuple[str, ...]]:
        """Return for each object: id recorded, id now, first list of each, s, and how far apart they were, m."""
        rows: list[tuple[str, ...]] = []
        for number, one in sorted(self.recorded.items(), key=lambda item: item[1].first_ns):
            partner = next(iter(one.partners.most_common(1)), None)
            if partner is None:
                rows.append((str(number), "-", self._second(one), "-", f"only recorded, in {one.lists} lists"))
                continue
            other = self.now[partner[0]]
            apart = f"{np.mean(one.apart_m):.2f} m apart, at most {max(one.apart_m):.2f}"
            rows.append((str(number), str(partner[0]), self._second(one), self._second(other), apart))
        for number, one in sorted(self.now.items(), key=lambda item: item[1].first_ns):
            if not one.partners:
                rows.append(("-", str(number), "-", self._second(one), f"only now, in {one.lists} lists"))
        return rows

    def _second(self, one: Sighting) -> str:
        return f"{(one.first_ns - (self.begin_ns or 0)) / NS:.2f}"


def compare_runs(recording: Recording, config: OnboardConfig) -> "tuple[Differences, Counter[str]]":
    """Run pipeline and tracker with another configuration, the tracker on what that pipeline finds. Raises OdsError."""
    counters: Counter[str] = Counter()
    pipeline, tracker = PipelineRerun(recording, config, counters), TrackerRerun(recording, config, counters)
    found = ((pair.log_ns, pair.again) for pair in pipeline.run() if pair.again is not None)
    differences = Differences()
    for pair in shown(tracker.run(found), tracker.lists):
        differences.add(pair)
    return differences, counters


def print_differences(differences: Differences, counters: "Counter[str]") -> None:
    """Print the table of objects."""
    console = Console(highlight=False)
    rows = differences.rows()
    table = Table("id recorded", "id now", "first listed, s", "now, s", "")
    for row in islice(rows, MOST_ROWS):
        table.add_row(*row)
    console.print(table)
    if len(rows) > MOST_ROWS:
        console.print(f"and {len(rows) - MOST_ROWS} more")
    both = sum(row[0] != "-" and row[1] != "-" for row in rows)
    only = sum(row[1] == "-" for row in rows)
    console.print(
        f"{differences.lists} lists, {both} objects of both, {only} only recorded, {len(rows) - both - only} only now",
        soft_wrap=True,
    )
    noted = [f"{name} {count}" for name, count in sorted(counters.items()) if count]
    if noted:
        console.print(", ".join(noted), soft_wrap=True)


def _noted(seen: dict[int, Sighting], original: ObstacleList) -> list[Obstacle]:
    """Record the obstacles of a list, and return those that are not terminated."""
    present = [o for o in original.obstacles if o.state != "terminated"]
    for obstacle in present:
        seen.setdefault(obstacle.id, Sighting(original.t_ns)).lists += 1
    return present


def _pairs(here: list[Obstacle], there: list[Obstacle]) -> list[tuple[int, int, float]]:
    """Return which obstacles stand for the same object, and how far they are apart, horizontally, m."""
    if not here or not there:
        return []
    a, b = (np.array([o.position_ned[:2] for o in each]) for each in (here, there))
    apart = np.hypot(*(a[:, None] - b[None]).transpose(2, 0, 1))
    rows, columns = linear_sum_assignment(np.where(apart > SAME_M, FAR, apart))
    return [
        (here[i].id, there[j].id, float(apart[i, j]))
        for i, j in zip(rows, columns, strict=True)
        if apart[i, j] <= SAME_M
    ]
