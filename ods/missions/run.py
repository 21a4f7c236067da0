"""`ods missions`: a campaign from its file to its results."""

import time
from argparse import Namespace
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import closing
from statistics import median

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ods import __version__
from ods.base.errors import OdsError, reason_of
from ods.base.settings_file import load
from ods.missions import report
from ods.missions.detections.fit import fit_to_file
from ods.missions.detections.laws import sonar_fingerprint
from ods.missions.journal import Journal
from ods.missions.outcome import Flown
from ods.missions.settings import Campaign
from ods.missions.setup import flight_of, setup_of
from ods.missions.watch import OnBoard
from ods.missions.workers import Task, flown_of


def run(args: Namespace) -> None:
    """Fly all missions that are not done yet and tell what came of all; or fit. Raises OdsError."""
    campaign = load(args.campaign, Campaign)
    console, began = Console(highlight=False), time.perf_counter()
    if args.fit is not None:
        fit_to_file(campaign, args.fit, console)
        return
    with closing(Journal(args.out, depends_on(campaign))) as journal:
        tasks = [Task(campaign, number, arm) for number in range(campaign.missions) for arm in campaign.arms]
        left = tasks[len(journal.done) :]
        costs: defaultdict[str, list[tuple[float, float]]] = defaultdict(list)
        for flown in _shown(flown_of(left, fly, args.workers), left, args.campaign.name):
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


def fly(task: Task) -> Flown:
    """Fly one mission, in any process. Raises OdsError."""
    began, campaign = time.process_time(), task.campaign
    flight = flight_of(campaign, task.number, task.arm, setup_of(campaign))
    outcome = flight.fly()
    spent_s = time.process_time() - began
    if not isinstance(flight.watch, OnBoard):
        return Flown(outcome, spent_s)
    return Flown(outcome, spent_s, median(flight.watch.finding_ms), median(flight.watch.tracking_ms))


def depends_on(campaign: Campaign) -> dict[str, object]:
    """Return all that the results of a campaign depend on. Raises OdsError."""
    setup = setup_of(campaign)
    return {
        "ods": __version__,
        "campaign": campaign,
        "onboard": setup.onboard,
        "sonar": sonar_fingerprint(setup.sonar),
        **({} if setup.laws is None else {"detections": setup.laws}),
    }


def _shown(flown: Iterator[Flown], tasks: Sequence[Task], name: str) -> Iterator[Flown]:
    """Yield them, with a bar that shows how many are done and the time left."""
    console = Console(stderr=True)
    columns = TextColumn(f"{name}:"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        row = bar.add_task("", total=len(tasks))
        for each in flown:
            bar.advance(row)
            yield each
