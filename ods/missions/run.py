"""`ods missions`: a campaign from its file to its results."""

import time
from argparse import Namespace
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import closing

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ods.base.errors import OdsError, reason_of
from ods.base.settings_file import load
from ods.missions import report
from ods.missions.detections.fit import fit_to_file
from ods.missions.fly import depends_on, fly, tasks_of
from ods.missions.journal import Journal
from ods.missions.outcome import Flown
from ods.missions.settings import Campaign
from ods.missions.workers import Task, flown_of


def run(args: Namespace) -> None:
    """Fly all missions that are not done yet and tell what came of all; or fit. Raises OdsError."""
    campaign = load(args.campaign, Campaign)
    console, began = Console(highlight=False), time.perf_counter()
    if args.fit is not None:
        fit_to_file(campaign, args.fit, console)
        return
    if args.chart:
        from ods.missions.chart.run import draw_campaign  # Matplotlib is an extra, which only pictures need

        draw_campaign(campaign, args.out, args.workers, args.style, console)
        return
    with closing(Journal(args.out, depends_on(campaign))) as journal:
        left = tasks_of(campaign)[len(journal.done) :]
        costs: defaultdict[str, list[tuple[float, float]]] = defaultdict(list)
        for flown in shown(flown_of(left, fly, args.workers), left, args.campaign.name):
            journal.add(flown.outcome)
            costs[flown.outcome.arm].append((flown.outcome.time_s, flown.cpu_s))
        result = report.result_of(campaign, journal.done)
        try:
            report.write(args.out, journal.done, result)
        except OSError as error:
            raise OdsError(f"{args.out}: {reason_of(error)}") from error
    console.print(report.table_of(result))
    for line in report.lines_of(result):
        console.print(line, soft_wrap=True)
    if left:
        spent_s = time.perf_counter() - began
        console.print(f"{len(left)} missions in {spent_s:.0f} s; so many times faster than real time on one core:")
    for arm, cost in costs.items():
        mission_s, cpu_s = map(sum, zip(*cost, strict=True))
        console.print(f"  {report.ARMS[arm]}: {mission_s / cpu_s:.1f}")


def shown(flown: Iterator[Flown], tasks: Sequence[Task], name: str) -> Iterator[Flown]:
    """Yield them, with a bar that shows how many are done and the time left."""
    console = Console(stderr=True)
    columns = TextColumn(f"{name}:"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        row = bar.add_task("", total=len(tasks))
        for each in flown:
            bar.advance(row)
            yield each
