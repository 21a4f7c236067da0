"""`ods missions`: a campaign from its file to its results."""

import time
from argparse import Namespace
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ods.base.errors import OdsError, reason_of
from ods.base.settings_file import load_variants
from ods.missions import report
from ods.missions.detections.fit import fit_to_file
from ods.missions.failing import table
from ods.missions.journal import Journal, file_name
from ods.missions.outcome import Flown, Outcome
from ods.missions.parallel.fly import depends_on, fly, tasks_of
from ods.missions.parallel.workers import Task, flown_of
from ods.missions.settings import Campaign


def run(args: Namespace) -> None:
    """Fly all missions that are not done yet and print the results of all; or fit. Raises OdsError."""
    variants = load_variants(args.campaign, Campaign)
    campaign = next(iter(variants.values()))
    console = Console(highlight=False)
    if len(variants) > 1 and (args.fit is not None or args.chart):
        raise OdsError(f"{args.campaign}: variant: goes without --fit and --chart")
    if args.fit is not None:
        fit_to_file(campaign, args.fit, console)
    elif args.chart:
        from ods.missions.chart.run import draw_campaign  # Matplotlib is an extra, which only pictures need

        draw_campaign(campaign, args.out, args.workers, args.style, console)
    elif "" in variants:
        _fly_one(campaign, args, console)
    else:
        _fly_variants(variants, args, console)


def _fly_variants(variants: Mapping[str, Campaign], args: Namespace, console: Console) -> None:
    """Run all variants, each in its own folder, and print their results in one table."""
    for name, campaign in variants.items():
        if not {"ods", "truth"} <= set(campaign.arms):
            raise OdsError(f"{args.campaign}: variant {name}: arms: variants are compared by ods and truth")
    with ExitStack() as open_files:
        journals = {
            name: open_files.enter_context(closing(Journal(args.out / file_name(name), depends_on(campaign))))
            for name, campaign in variants.items()
        }
        left = [(task, name) for name, campaign in variants.items() for task in _left(campaign, journals[name])]
        left.sort(key=lambda each: each[0].number)  # stopped at any time, all have gone through as many worlds
        tasks = [task for task, _ in left]
        for flown, (_, name) in zip(shown(_flown(tasks, args), tasks, args.campaign.name), left, strict=True):
            journals[name].add(flown.outcome)
    rows = []
    for name, campaign in variants.items():
        _write(args.out / file_name(name), journals[name].done, report.result_of(campaign, journals[name].done))
        rows.append(table.row_of(name, journals[name].done))
    try:
        table.write(rows, args.out / "variants.csv")
    except OSError as error:
        raise OdsError(f"{args.out}: {reason_of(error)}") from error
    console.print(table.table_of(rows))


def _fly_one(campaign: Campaign, args: Namespace, console: Console) -> None:
    began = time.perf_counter()
    with closing(Journal(args.out, depends_on(campaign))) as journal:
        left = _left(campaign, journal)
        costs: defaultdict[str, list[tuple[float, float]]] = defaultdict(list)
        for flown in shown(_flown(left, args), left, args.campaign.name):
            journal.add(flown.outcome)
            costs[flown.outcome.arm].append((flown.outcome.time_s, flown.cpu_s))
        result = report.result_of(campaign, journal.done)
        _write(args.out, journal.done, result)
    console.print(report.table_of(result))
    for line in report.lines_of(result):
        console.print(line, soft_wrap=True)
    if left:
        spent_s = time.perf_counter() - began
        console.print(f"{len(left)} missions in {spent_s:.0f} s; times faster than real time on one core:")
    for arm, cost in costs.items():
        mission_s, cpu_s = map(sum, zip(*cost, strict=True))
        console.print(f"  {report.ARMS[arm]}: {mission_s / cpu_s:.1f}")


def _flown(tasks: Sequence[Task], args: Namespace) -> Iterator[Flown]:
    if args.cluster is None:
        return flown_of(tasks, fly, args.workers)
    try:
        from ods.missions.parallel.cluster import flown_on_cluster  # of an extra
    except ModuleNotFoundError as error:
        raise OdsError(f"--cluster: needs {error.name}: pip install 'ods[cluster]'") from error
    return flown_on_cluster(tasks, fly, args.cluster, args.tls)


def _left(campaign: Campaign, journal: Journal) -> list[Task]:
    tasks = tasks_of(campaign)
    if len(journal.done) > len(tasks):
        raise OdsError(
            f"missions: {len(journal.done) // len(campaign.arms)} have already been run there, more than requested"
        )
    return tasks[len(journal.done) :]


def _write(folder: Path, outcomes: Sequence[Outcome], result: report.Result) -> None:
    try:
        report.write(folder, outcomes, result)
    except OSError as error:
        raise OdsError(f"{folder}: {reason_of(error)}") from error


def shown(flown: Iterator[Flown], tasks: Sequence[Task], name: str) -> Iterator[Flown]:
    """Yield them, with a bar that shows how many are done and the time left."""
    console = Console(stderr=True)
    columns = TextColumn(f"{name}:"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        row = bar.add_task("", total=len(tasks))
        for each in flown:
            bar.advance(row)
            yield each
