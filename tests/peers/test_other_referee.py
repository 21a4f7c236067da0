"""Campaigns judge collisions and clearance as uFldCollObDetect of MOOS-IvP does, from the same ways and obstacles."""

import functools
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from ods.base.arrays import Floats
from ods.base.settings_file import load_variants
from ods.missions.flight import Flight
from ods.missions.outcome import Outcome
from ods.missions.settings import Arm, Campaign
from ods.missions.setup import flight_of, setup_of
from tests.peers.moos import needs
from tests.peers.other_referee import CORNER, ENCOUNTER_M, Judged, judged

pytestmark = needs("uFldCollObDetect")

DENSE = Path(__file__).parents[2] / "config" / "campaigns" / "dense.toml"
MISSIONS: dict[Arm, int] = {"none": 6, "ods": 1, "truth": 3, "all_knowing": 2}
EXACT_M = 1e-5
"""Of distances that are computed alike. Those of outcomes are rounded to"""
ROUNDED_M = 5e-4


@pytest.mark.parametrize("moving_share", [0.0, 0.3])
def test_it_agrees_on_all_encounters(moving_share: float) -> None:
    """A polygon is a little nearer than the circle in it, and may have gone on a step before the vehicle."""
    dense = load_variants(DENSE, Campaign)[""]
    campaign = replace(dense, world=replace(dense.world, moving_share=moving_share))
    setup = setup_of(campaign)
    flights = [flight_of(campaign, number, arm, setup) for arm, count in MISSIONS.items() for number in range(count)]
    outcomes = [flight.fly() for flight in flights]
    with ThreadPoolExecutor(len(flights)) as pool:  # the programs mostly wait
        verdicts = list(pool.map(functools.partial(judged, campaign), flights))
    for flight, outcome, said in zip(flights, outcomes, verdicts, strict=True):
        nearest, early_m = nearest_of(flight), early_of(flight)
        assert_encounters(said, nearest, early_m)
        assert_outcome(said, outcome, campaign, early_m)
        print(summary(said, outcome, nearest))
    assert {outcome.ending for outcome in outcomes} == {"collision", "success"}
    assert any(outcome.near_miss for outcome in outcomes)


def assert_encounters(said: Judged, nearest: Floats, early_m: Floats) -> None:
    for number, (distance_m, early) in enumerate(zip(nearest.tolist(), early_m.tolist(), strict=True)):
        if abs(distance_m - ENCOUNTER_M) > early + EXACT_M:
            assert (number in said.encounters) == (distance_m < ENCOUNTER_M)
        if number in said.encounters:
            assert -early - EXACT_M <= said.encounters[number] - distance_m <= EXACT_M


def assert_outcome(said: Judged, outcome: Outcome, campaign: Campaign, early_m: Floats) -> None:
    assert outcome.clearance_m is not None
    number, least_m = min(said.encounters.items(), key=lambda each: each[1])
    off_m = least_m - campaign.vehicle.radius_m - outcome.clearance_m
    assert -early_m[number] - ROUNDED_M <= off_m <= ROUNDED_M
    assert bool(said.collisions) == (outcome.ending == "collision")
    assert bool(said.near_misses) == outcome.near_miss or bool(said.collisions)


def nearest_of(flight: Flight) -> Floats:
    """Return (n,) how near the vehicle's centre came to each obstacle, as campaigns judge it, m."""
    way = flight.vehicle.way[1:]
    clear = [flight.world.clearances(at.t_s, at.north_m, at.east_m, at.down_m) for at in way]
    return np.asarray(np.min(clear, axis=0))


def early_of(flight: Flight) -> Floats:
    """Return (n,) by how much the other referee may see each obstacle nearer, m."""
    world, way = flight.world, flight.vehicle.way
    step_s = way[1].t_s - way[0].t_s
    return np.asarray(world.radius_m * (CORNER - 1.0) + np.hypot(*world.velocity.T) * step_s)


def summary(said: Judged, outcome: Outcome, nearest: Floats) -> str:
    off_mm = [1e3 * (distance_m - nearest[number]) for number, distance_m in said.encounters.items()]
    return (
        f"{outcome.arm} {outcome.mission}: {outcome.ending}, clearance {outcome.clearance_m} m; "
        f"{len(off_mm)} encounters, {min(off_mm):+.1f} to {max(off_mm):+.1f} mm"
    )
