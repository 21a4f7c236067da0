"""Parts of a campaign's missions: sonar, settings of pipeline and tracker, laws of detections."""

from dataclasses import replace
from typing import NamedTuple

import msgspec

from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.config import OnboardConfig, part_of
from ods.missions.detections.laws import Laws, load_laws, refuse_others
from ods.missions.flight import Flight
from ods.missions.settings import Arm, Campaign
from ods.missions.world import World
from ods.offline.mission import MissionSettings
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.sonar.model import SonarModel

LEAST_SAMPLES = 10


class Setup(NamedTuple):
    """The same for all missions of a campaign."""

    sonar: SonarModel
    onboard: MissionSettings
    laws: Laws | None


def setup_of(campaign: Campaign) -> Setup:
    """Return it. Raises OdsError, which names the key."""
    sonar, onboard = sonar_of(campaign), onboard_of(campaign)
    laws = None
    if campaign.fidelity == "detections" and campaign.detections is not None:
        laws = load_laws(campaign.detections)
        refuse_others(laws, campaign, onboard.pipeline, sonar)
    return Setup(sonar, onboard, laws)


def sonar_of(campaign: Campaign) -> SonarModel:
    """Return the sonar, set to the campaign's range. Raises OdsError."""
    sonar = find_sonar(campaign.sonar)
    if sonar.pixels is not None and (campaign.errors.fault or campaign.errors.range_scale != 1.0):
        raise OdsError(f"errors: fault, range_scale: {sonar.name} sends range images, which are simulated without them")
    if campaign.range_m is None:
        return sonar
    samples = round((campaign.range_m - sonar.range0_m) / sonar.dr_m) + 1
    if samples < LEAST_SAMPLES:
        raise OdsError(f"range_m: {campaign.range_m:g} m is too short for {sonar.name}")
    return replace(sonar, samples=samples)


def onboard_of(campaign: Campaign) -> MissionSettings:
    """Return the settings of pipeline and tracker. Raises OdsError."""
    if campaign.onboard is None:
        settings = MissionSettings()
    else:
        settings = part_of(load(campaign.onboard, OnboardConfig), MissionSettings)
    own = {"pipeline": campaign.pipeline, "tracker": campaign.tracker}
    return msgspec.structs.replace(settings, **{key: value for key, value in own.items() if value is not None})


def flight_of(campaign: Campaign, number: int, arm: Arm, setup: Setup, world: World | None = None) -> Flight:
    """Return a mission before its start. Raises OdsError."""
    return Flight(campaign, number, arm, setup.sonar, setup.onboard, world, setup.laws)
