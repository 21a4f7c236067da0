"""One mission in whatever process, and what results depend on."""

import time
from statistics import median

from msgspec.structs import replace

from ods import __version__
from ods.missions.detections.laws import sonar_fingerprint
from ods.missions.outcome import Flown
from ods.missions.parallel.workers import Task
from ods.missions.settings import Campaign
from ods.missions.setup import flight_of, setup_of
from ods.missions.watch import OnBoard


def tasks_of(campaign: Campaign) -> list[Task]:
    """Return all missions of a campaign, in their order."""
    return [Task(campaign, number, arm) for number in range(campaign.missions) for arm in campaign.arms]


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
    """Return all that the results of a campaign depend on; more missions go on from fewer. Raises OdsError."""
    setup = setup_of(campaign)
    return {
        "ods": __version__,
        "campaign": replace(campaign, missions=1),
        "onboard": setup.onboard,
        "sonar": sonar_fingerprint(setup.sonar),
        **({} if setup.laws is None else {"detections": setup.laws}),
    }
