"""`ods missions`: a campaign from its file to its results."""

import time
from argparse import Namespace
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import fields
from hashlib import sha256

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ods import __version__
from ods.base.errors import OdsError, reason_of
from ods.base.settings_file import load
from ods.config import OnboardConfig, part_of
from ods.missions import report
from ods.missions.flight import Flight
from ods.missions.journal import Journal
from ods.missions.outcome import Flown
from ods.missions.settings import Campaign
from ods.missions.workers import Task, flown_of
from ods.offline.mission import MissionSettings
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.sonar.model import SonarModel


def run(args: Namespace) -> None:
    """Fly all missions that are not done yet and tell what came of all. Raises OdsError."""
    campaign = load(args.campaign, Campaign)
    depends_on = {
        "ods": __version__,
        "campaign": campaign,
        "onboard": _onboard(campaign),
        "sonar": _fingerprint(find_sonar(campaign.sonar)),
    }
    console, began = Console(highlight=False), time.perf_counter()
    with closing(Journal(args.out, depends_on)) as journal:
        tasks = [Task(campaign, number, arm) for number in range(campaign.missions) for arm in campaign.arms]
        left = tasks[len(journal.done) :]
        costs: defaultdict[str, list[tuple[float, float]]] = defaultdict(list)
        for outcome, cpu_s in _shown(flown_of(left, fly, args.workers), left, args.campaign.name):
            journal.add(outcome)
            costs[outcome.arm].append((outcome.time_s, cpu_s))
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
    outcome = Flight(campaign, task.number, task.arm, find_sonar(campaign.sonar), _onboard(campaign)).fly()
    return Flown(outcome, time.process_time() - began)


def _onboard(campaign: Campaign) -> MissionSettings:
    if campaign.onboard is None:
        return MissionSettings()
    return part_of(load(campaign.onboard, OnboardConfig), MissionSettings)


def _fingerprint(sonar: SonarModel) -> str:
    """Return what no two sonars have in common, whatever their names."""
    parts = [getattr(sonar, field.name) for field in fields(sonar)]
    return sha256(b"".join(np.asarray(part).tobytes() for part in parts)).hexdigest()


def _shown(flown: Iterator[Flown], tasks: Sequence[Task], name: str) -> Iterator[Flown]:
    """Yield them, with a bar that shows how many are done and the time left."""
    console = Console(stderr=True)
    columns = TextColumn(f"{name}:"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        row = bar.add_task("", total=len(tasks))
        for each in flown:
            bar.advance(row)
            yield each
