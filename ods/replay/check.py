"""`ods replay --check`: tests whether this version reproduces a recording's output."""

from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.progress import track as progress

from ods.config import OnboardConfig
from ods.messages import Detections
from ods.recording.facts import facts
from ods.recording.mcap.reader import Recording
from ods.replay.compare import ENOUGH, NEAR_M, NEAR_RAD, Compared, Verdict, compare_detections, compare_lists
from ods.replay.machine import differences
from ods.replay.rerun import ListPair, PipelineRerun, TrackerRerun
from ods.replay.setup import recorded_config

GOOD = {Verdict.SAME, Verdict.ROUNDED, Verdict.SAME_BUT_HEALTH}
MOST_SHOWN = 3


class Tally:
    """Counts verdicts, and keeps the first differences."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.counts: Counter[Verdict] = Counter()
        self.where: list[str] = []

    def add(self, compared: Compared) -> None:
        """Count one message."""
        self.counts[compared.verdict] += 1
        if compared.where and len(self.where) < MOST_SHOWN:
            self.where.append(compared.where)

    def holds(self, exactly: bool) -> bool:
        """Return whether enough of them are as they have to be: all, or, not `exactly`, most within tolerances."""
        total = self.counts.total()
        good = sum(count for verdict, count in self.counts.items() if verdict in GOOD)
        return good == total if exactly else good + self.counts[Verdict.NEAR] >= ENOUGH * total

    def line(self) -> str:
        """Return the counts as one line."""
        verdicts = [f"{self.counts[verdict]} {verdict.value}" for verdict in Verdict if self.counts[verdict]]
        return f"{self.counts.total()} {self.what}: {', '.join(verdicts) or 'none'}"


class Result(NamedTuple):
    """Result of a check."""

    detections: Tally
    lists: Tally
    counters: "Counter[str]"
    other: list[str]
    """What is not as it was when it was recorded; empty: bytes have to be the same."""

    @property
    def holds(self) -> bool:
        """All that was recorded came out again."""
        exactly = not self.other
        return self.detections.holds(exactly) and self.lists.holds(exactly) and self.lists.counts.total() > 0


def check(recording: Recording, config: OnboardConfig | None = None) -> Result:
    """Run pipeline and tracker again. Raises OdsError.

    The tracker gets the detections that were recorded, so that each is judged for itself.
    """
    chosen = recorded_config(recording) if config is None else config
    counters: Counter[str] = Counter()
    result = Result(Tally("pings with detections"), Tally("obstacle lists"), counters, other_here(recording))
    pipeline, tracker = PipelineRerun(recording, chosen, counters), TrackerRerun(recording, chosen, counters)

    def checked() -> Iterator[tuple[int, Detections]]:
        for pair in pipeline.run():
            result.detections.add(compare_detections(pair))
            yield pair.log_ns, pair.recorded

    detections = checked()
    for pair in shown(tracker.run(detections), tracker.lists):
        result.lists.add(compare_lists(pair))
    for _ in detections:
        pass  # those behind the last list
    return result


def other_here(recording: Recording) -> list[str]:
    """Return the differences of computer and programs, a text each."""
    return differences(recording.metadata.get("ods", {}), facts(""))


def shown(pairs: Iterable[ListPair], count: int) -> Iterable[ListPair]:
    """Return the same with a bar that shows how far it is."""
    console = Console(stderr=True)
    return progress(pairs, "replaying:", total=count, console=console, disable=not console.is_terminal)


def report(result: Result, path: Path) -> None:
    """Print the result of a check."""
    console = Console(highlight=False, soft_wrap=True)
    for tally in (result.detections, result.lists):
        console.print(tally.line())
        for where in tally.where:
            console.print(f"    {where}", markup=False)
    noted = [f"{name} {count}" for name, count in sorted(result.counters.items()) if count]
    if noted:
        console.print(", ".join(noted))
    if result.other:
        for line in result.other:
            console.print(line, markup=False)
        console.print(f"so within {NEAR_M:g} m and {NEAR_RAD:g} rad, for {ENOUGH:.0%} of them")
    console.print(f"{path}: " + ("as recorded" if result.holds else "NOT as recorded"), markup=False)
