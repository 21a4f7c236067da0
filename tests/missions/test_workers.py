"""Missions on several processes, of which some are killed."""

import os
import signal
from pathlib import Path

import pytest

from ods.base.errors import OdsError
from ods.missions.outcome import Flown, Outcome
from ods.missions.parallel.workers import Task, flown_of
from ods.missions.settings import Campaign


def outcome(number: int) -> Outcome:
    return Outcome(
        mission=number, arm="none", ending="success", near_miss=False, clearance_m=None, path_m=1.0, time_s=1.0,
        evasions=0, evasions_of_nothing=0, listed=0, first_listed_m=None, time_to_collision_s=None, not_valid_s=0.0,
        nearest_listed=False, warning="",
    )  # fmt: skip


def killed_once(task: Task) -> Flown:
    """Die in mission 3 unless somebody died before; the campaign's sonar is the mark of that."""
    mark = Path(task.campaign.sonar)
    if task.number == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return Flown(outcome(task.number), 0.0)


def killed_always(task: Task) -> Flown:
    if task.number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return Flown(outcome(task.number), 0.0)


def wrong(task: Task) -> Flown:
    raise OdsError(f"mission {task.number}")


def tasks(tmp_path: Path, count: int = 12) -> list[Task]:
    campaign = Campaign(seed=1, sonar=str(tmp_path / "killed"))
    return [Task(campaign, number, "none") for number in range(count)]


@pytest.mark.slow
def test_a_killed_process_s_mission_is_flown_again_and_all_come_in_order(tmp_path: Path) -> None:
    assert [flown.outcome for flown in flown_of(tasks(tmp_path), killed_once, 2)] == [outcome(k) for k in range(12)]
    assert (tmp_path / "killed").exists()


@pytest.mark.slow
def test_a_mission_that_always_kills_its_process_is_named(tmp_path: Path) -> None:
    with pytest.raises(OdsError, match=r"mission [0-3] of arm 'none'.*killed 3 times"):
        list(flown_of(tasks(tmp_path), killed_always, 2))


@pytest.mark.slow
def test_what_a_mission_cannot_do_is_reported_as_from_one_process(tmp_path: Path) -> None:
    for workers in (1, 2):
        with pytest.raises(OdsError, match="mission 0"):
            list(flown_of(tasks(tmp_path), wrong, workers))
