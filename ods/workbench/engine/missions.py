"""Missions of a campaign, the worst first, and one of them flown again with the planner in the loop."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import msgspec

from ods.base.errors import OdsError, reason_of
from ods.base.files.in_file import MOST_BYTES, content_of
from ods.base.settings_file import load_variants
from ods.missions.journal import NAME
from ods.missions.outcome import Outcome
from ods.missions.settings import Arm, Campaign
from ods.workbench.engine.background.own_process import GoesOn

MOST_SHOWN = 20
ARM: Arm = "ods"
"""Of the missions that are shown: the one that receives the list."""

Place = tuple[float, float]


class Choice(NamedTuple):
    """A mission that can be flown."""

    campaign: Campaign
    name: str
    """Of its variant, or of its folder."""
    number: int
    outcome: Outcome | None
    """What came of it; none: it has not been flown."""


class Voyage(NamedTuple):
    """What came of a mission, as places north, east, m."""

    outcome: Outcome
    way: list[Place]
    goal: Place
    obstacles: list[tuple[Place, float]]
    """Place and radius of each obstacle at the end."""
    paths: list[tuple[Place, Place]]
    """From where to where those went that move."""
    listed: list[tuple[Place, float]]
    """Place and radius of each object of the last list."""


class _Head(msgspec.Struct):
    campaign: Campaign


def choices_of(path: Path) -> list[Choice]:
    """Return the missions of a campaign's file, or the worst of a folder of results. Raises OdsError."""
    if path.is_dir():
        files = sorted([*path.glob(NAME), *path.glob(f"*/{NAME}")])
        if not files:
            raise OdsError(f"{path}: no {NAME} in it: ods missions CAMPAIGN.toml --out {path}")
        found = [choice for file in files for choice in _of_journal(file)]
        return sorted(found, key=_badness)[:MOST_SHOWN]
    variants = load_variants(path, Campaign)
    return [
        Choice(campaign, name or path.stem, number, None)
        for number in range(max(each.missions for each in variants.values()))
        for name, campaign in variants.items()
        if number < campaign.missions
    ][:MOST_SHOWN]


def _of_journal(file: Path) -> Iterator[Choice]:
    try:
        head, *lines = content_of(file, MOST_BYTES).splitlines()
        campaign = msgspec.json.decode(head, type=_Head, dec_hook=_path_of).campaign
        outcomes = [msgspec.json.decode(line, type=Outcome) for line in lines]
    except OSError as error:
        raise OdsError(f"{file}: {reason_of(error)}") from error
    except (ValueError, msgspec.MsgspecError) as error:
        raise OdsError(f"{file}: from another version of ODS, or not results of missions: {error}") from error
    return (Choice(campaign, file.parent.name, each.mission, each) for each in outcomes if each.arm == ARM)


def _path_of(kind: type, value: object) -> object:
    """Return a path, the only type of a campaign that JSON does not know."""
    return kind(str(value))


def _badness(choice: Choice) -> tuple[bool, float]:
    """Return the key to sort by: collisions come before least clearances."""
    outcome = choice.outcome
    assert outcome is not None
    return outcome.ending != "collision", math.inf if outcome.clearance_m is None else outcome.clearance_m


def fly(report: GoesOn, choice: Choice) -> Voyage | None:
    """Fly a mission with the list of pipeline and tracker; None: `report` asked to give up. Raises OdsError.

    progress: gets the share of the straight way that is done, 0 to 1.
    """
    from ods.missions.setup import flight_of, setup_of  # the simulator: not in the page's process

    campaign = choice.campaign
    flight = flight_of(campaign, choice.number, ARM, setup_of(campaign))
    for state in flight.pings():
        if not report(min(1.0, max(0.0, state.north_m / campaign.world.length_m))):
            return None
    world, now = flight.world, flight.vehicle.way[-1].t_s
    start, end = world.places(0.0).tolist(), world.places(now).tolist()
    obstacles = [] if flight.received is None else flight.received.list.obstacles
    return Voyage(
        flight.outcome(),
        [(state.north_m, state.east_m) for state in flight.vehicle.way[::4]],
        (campaign.world.length_m, 0.0),
        [((n, e), r) for (n, e), r in zip(end, world.radius_m.tolist(), strict=True)],
        [((a, b), (c, d)) for (a, b), (c, d) in zip(start, end, strict=True) if (a, b) != (c, d)],
        [(each.position_ned[:2], each.radius_m) for each in obstacles],
    )
