"""Campaigns with what nothing was tuned on: variants, errors that nobody on board knows, and what the list said."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from ods.base.clock import NS
from ods.base.files.shipped import shipped_file
from ods.base.frames.mounting import MountingSettings
from ods.base.frames.quaternion import from_euler
from ods.base.settings_file import load_variants
from ods.cli import main
from ods.messages import Clearance, ObstacleList, Pose, PoseAt
from ods.missions.failing.errors import ErrorSettings
from ods.missions.failing.table import HEADERS, cells_of, row_of
from ods.missions.failing.witness import Witness
from ods.missions.flight import Flight
from ods.missions.outcome import Ending, Outcome
from ods.missions.settings import Campaign, WorldSettings
from ods.missions.watch import TruthWatch
from ods.missions.world import World, make_world
from ods.offline.mission import MissionSettings
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.settings import FaultSettings
from ods.sim_sonar.steered import VehicleState

VARIED = """
seed = 3
missions = 1
[world]
length_m = 45.0
width_m = 40.0
obstacles_per_hectare = 0.0
current_m_s = 0.0
[[variant]]
name = "as tuned"
[[variant]]
name = "dead ends / fast"
world.dead_ends = 1
world.dead_end_m = 4.0
arms = ["ods", "truth"]
"""
SILENT = 'errors.fault = [{ kind = "ins_silent", at_s = 0.0, for_s = 1.0 }]'
STILL = (0.0, 0.0, 0.0)
SECTORS = 72


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    file = tmp_path / "campaign.toml"
    file.write_text(VARIED)
    return file


def test_a_variant_sets_keys_anew_and_keeps_the_others(campaign: Path) -> None:
    tuned, dead = load_variants(campaign, Campaign).values()
    assert (tuned.world.dead_ends, dead.world.dead_ends) == (0, 1)
    assert dead.world.length_m == tuned.world.length_m == 45.0
    assert dead.arms == ("ods", "truth")


@pytest.mark.parametrize(
    ("old", "new", "reported"),
    [
        ("world.dead_ends = 1", "world.dead_end = 1", "variant[1] (dead ends / fast): world.dead_end: unknown key"),
        ('name = "as tuned"', "", "variant[0].name"),
        ('name = "as tuned"', 'name = "dead ends / fast"', "variant[1].name"),
        ('arms = ["ods", "truth"]', 'arms = ["ods"]', "arms: variants are compared by ods and truth"),
        (
            "world.dead_ends = 1",
            'errors.fault = [{ kind = "ins_silent", at_s = 0.0, for_s = 1.0 }]',
            "ins_silent does not apply to images",
        ),
    ],
)
def test_mistakes_in_variants_are_one_line(
    campaign: Path, old: str, new: str, reported: str, capsys: pytest.CaptureFixture[str]
) -> None:
    campaign.write_text(VARIED.replace(old, new))
    assert main(["missions", str(campaign), "--out", str(campaign.parent / "out")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert reported in line


@pytest.mark.slow
def test_all_variants_are_flown_and_reported_in_one_table_and_more_missions_go_on(campaign: Path) -> None:
    out = campaign.parent / "out"
    assert main(["missions", str(campaign), "--out", str(out)]) == 0
    rows = (out / "variants.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["variant", "as tuned", "dead ends / fast"]
    first = (out / "as-tuned" / "missions.jsonl").read_bytes()
    campaign.write_text(VARIED.replace("missions = 1", "missions = 2"))
    assert main(["missions", str(campaign), "--out", str(out)]) == 0
    assert (out / "as-tuned" / "missions.jsonl").read_bytes().startswith(first)
    assert json.loads((out / "as-tuned" / "summary.json").read_bytes())["arms"][0]["success"]["of"] == 2


def test_the_shipped_campaign_is_one(tmp_path: Path) -> None:
    variants = load_variants(shipped_file("campaigns/failing.toml"), Campaign)
    assert len(variants) > 20
    assert all(each.world.length_m == 80.0 for each in variants.values())


def test_a_dead_end_has_no_gap_and_is_open_towards_the_start() -> None:
    settings = WorldSettings(length_m=100.0, obstacles_per_hectare=0.0, dead_ends=1, dead_end_m=12.0)
    places = make_world(settings, 1, 0).start_m
    north, east = places.T
    middle = north.min(), 0.5 * (east.min() + east.max())
    assert np.hypot(*(places - middle).T) == pytest.approx(12.0)
    assert north.min() == pytest.approx(50.0)
    assert np.hypot(*np.diff(places, axis=0).T).max() < 2.0


def test_poses_are_reported_with_their_errors() -> None:
    errors = ErrorSettings(range_scale=1.05, drift_m_s=(0.0, 0.5), yaw_drift_deg_s=1.0)
    pose = Pose(0, 10 * NS, 10 * NS, (1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), STILL, (0.1,) * 3, (0.01,) * 3)
    reported = errors.pose(pose)
    assert reported.position_ned == (1.0, 7.0, 3.0)
    assert reported.attitude == pytest.approx(from_euler(0.0, 0.0, math.radians(10.0)))
    assert reported.sigma_position_ned == pose.sigma_position_ned
    assert ErrorSettings().pose(pose) is pose


def test_faults_last_as_long_as_they_say() -> None:
    errors = ErrorSettings(fault=(FaultSettings(kind="dead_beams", at_s=2.0, for_s=3.0),))
    assert [errors.faults_at(t) for t in (1.9, 2.0, 4.9, 5.0)] == [[], ["dead_beams"], ["dead_beams"], []]


def state(t_s: float, heading: float = 0.0) -> VehicleState:
    return VehicleState(t_s, 0.0, 0.0, 20.0, heading, 2.0, 0.0, 0.0, (2.0, 0.0))


def clearance(to_m: float, *, valid: bool = True) -> Clearance:
    return Clearance(0, 0, 0, 0, valid, [0.0] * SECTORS, [to_m] * SECTORS, [None] * SECTORS)


def empty(**more: object) -> ObstacleList:
    pose = PoseAt((0.0, 0.0, 20.0), (1.0, 0.0, 0.0, 0.0), STILL, STILL, STILL)
    return ObstacleList(0, 0, 0, 0, 0, more.pop("valid", True) is True, [], [], pose=pose, **more)  # type: ignore[arg-type]


def one(north: float) -> World:
    return World(WorldSettings(), np.array([[north, 0.0]]), np.zeros((1, 2)), np.array([1.0]), (0.0, 0.0), 1)


def test_a_witness_tells_silence_from_warnings() -> None:
    """The obstacle's edge is 19 m ahead, and it is in no list."""

    def said(reported: ObstacleList, clear: Clearance | None) -> tuple[bool, str]:
        witness = Witness(one(20.0))
        witness.receive(reported, clear, state(0.0), 0.1)
        return witness.before(1.0, 0)

    assert said(empty(), clearance(50.0)) == (False, "")
    assert said(empty(), clearance(10.0)) == (False, "unknown water")
    assert said(empty(), None) == (False, "unknown water")
    assert said(empty(caution="images repeat"), clearance(50.0)) == (False, "caution")
    assert said(empty(valid=False), clearance(50.0)) == (False, "not valid")
    early = Witness(one(20.0))
    early.receive(empty(valid=False), clearance(50.0), state(0.0), 0.1)
    early.receive(empty(), clearance(50.0), state(8.0), 8.1)
    assert early.before(9.0, 0) == (False, "")


def test_what_is_listed_is_found_though_the_pose_reported_has_drifted() -> None:
    world = one(20.0)
    reported = TruthWatch(world, 100.0).look(0, state(0.0)).list
    turned = PoseAt((100.0, 50.0, 20.0), from_euler(0.0, 0.0, 0.5 * math.pi), STILL, STILL, STILL)

    def is_listed(place: tuple[float, float, float]) -> bool:
        witness = Witness(world)
        there = replace(reported.obstacles[0], position_ned=place)
        witness.receive(replace(reported, pose=turned, obstacles=[there]), None, state(0.0), 0.1)
        return witness.before(1.0, 0)[0]

    assert is_listed((100.0, 70.0, 20.0))
    assert not is_listed((120.0, 50.0, 20.0))


@pytest.mark.slow
def test_errors_and_faint_bodies_reach_the_list() -> None:
    usual, faint, turned, scaled = (
        first_list(**more) for more in ({}, {"heard_within_m": 8.0}, {"yaw_deg": 30.0}, {"range_scale": 1.05})
    )
    assert usual == pytest.approx((30.0, 0.0), abs=0.7)
    assert faint is None
    assert turned == pytest.approx((26.4, -13.5), abs=0.7)  # it has gone 3 m
    assert scaled == pytest.approx((31.5, 0.0), abs=0.7)


def first_list(
    *, heard_within_m: float | None = None, yaw_deg: float = 0.0, range_scale: float = 1.0
) -> tuple[float, float] | None:
    """Return where the only obstacle, 30 m ahead, is listed after 3 s, seen from the start; None: it is not."""
    world = WorldSettings(length_m=60.0, current_m_s=0.0, heard_within_m=heard_within_m)
    errors = ErrorSettings(range_scale=range_scale, mounting=MountingSettings(yaw_deg=yaw_deg))
    there = World(world, np.array([[30.0, 0.0]]), np.zeros((1, 2)), np.array([1.0]), (0.0, 0.0), 1)
    campaign = Campaign(seed=1, world=world, errors=errors)
    flight = Flight(campaign, 0, "ods", find_sonar("seabat6012"), MissionSettings(), there)
    for ping in range(20):
        flight.step(ping)
    assert flight.received is not None
    if not flight.received.list.obstacles:
        return None
    (north, east, _), at = flight.received.list.obstacles[0].position_ned, flight.vehicle.way[-1]
    return north + (range_scale - 1.0) * at.north_m, east


def outcome(number: int, arm: str, clearance_m: float, *, listed: bool = True, warning: str = "") -> Outcome:
    ending: Ending = "collision" if clearance_m < 0.0 else "success"
    return Outcome(
        mission=number, arm=arm, ending=ending, near_miss=0.0 <= clearance_m < 1.0, clearance_m=clearance_m,
        path_m=70.0, time_s=40.0, evasions=0, evasions_of_nothing=0, listed=1, first_listed_m=30.0, not_valid_s=4.0,
        time_to_collision_s=None, nearest_listed=listed, warning=warning,
    )  # fmt: skip


def test_a_row_splits_what_went_wrong_into_listed_warned_and_silent() -> None:
    own = [
        outcome(0, "ods", -0.1),
        outcome(1, "ods", -0.2, listed=False, warning="unknown water"),
        outcome(2, "ods", 0.5, listed=False),
        outcome(3, "ods", 4.0, listed=False),
    ]
    row = row_of("faint", [*own, *(outcome(number, "truth", 3.0) for number in range(4))])
    assert (row.listed, row.warned, row.silent) == (1, 1, 1)
    assert (row.collisions["ods"].count, row.near_misses, row.only_ods, row.only_truth) == (2, 1, 2, 0)
    assert row.clearance_m == {"ods": pytest.approx(0.2), "truth": 3.0}
    assert row.not_valid_share == pytest.approx(0.1)
    assert len(cells_of(row)) == len(HEADERS)
