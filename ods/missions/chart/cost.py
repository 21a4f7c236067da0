"""Cost of a variant on board: CPU time of pipeline and tracker, by images."""

from statistics import median

from ods.missions.settings import Campaign
from ods.missions.setup import Setup, flight_of, onboard_of, sonar_of
from ods.missions.watch import OnBoard
from ods.missions.world import FIRST_TO_FIT

PINGS, WARM_UP = 160, 20
"""Pings that are measured, and those before, which prepare."""


def ms_a_ping(campaign: Campaign) -> float:
    """Return the median CPU time a ping, in one world that no campaign flies, ms. Raises OdsError."""
    flight = flight_of(campaign, FIRST_TO_FIT, "ods", Setup(sonar_of(campaign), onboard_of(campaign), None))
    watch = flight.watch
    assert isinstance(watch, OnBoard)
    for ping in range(WARM_UP + PINGS):
        flight.step(ping)
    sums = [one + other for one, other in zip(watch.finding_ms, watch.tracking_ms, strict=True)]
    return round(median(sums[WARM_UP:]), 3)
