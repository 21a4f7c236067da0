"""A mission run again in the background, against `Mission` itself."""

import threading
from collections.abc import Iterator
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from ods.messages import ObstacleList
from ods.offline.mission import Mission, Step
from ods.tracker.existence.lifecycle import ACTIVE, TENTATIVE
from ods.workbench.engine.background.own_process import whole
from ods.workbench.engine.data import open_data
from ods.workbench.engine.mission import rerun
from ods.workbench.engine.mission.rerun import MissionRuns, Rerun, Wanted, wanted
from ods.workbench.engine.mission.tracked import Tracked
from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.scene.edits import scene_of
from ods.workbench.model.state import DataReference, State

SCENE = {
    "seed": 1,
    "duration_s": 6.0,
    "vehicle": {"position_ned": [0.0, 0.0, 0.0], "velocity_ned": [0.6, 0.0, 0.0]},
    "objects": [
        {"shape": "sphere", "name": "rock", "position_ned": [30.0, 4.0, 0.0], "radius_m": 1.5},
        {"shape": "sphere", "name": "boat", "position_ned": [40.0, -9.0, 0.0], "velocity_ned": [-0.5, 0.4, 0.0],
         "radius_m": 2.0},
    ],
    "image": {"gain": 20000.0, "noise_counts": 30.0},
}  # fmt: skip
START = apply(State(), do.OpenData(DataReference(kind="scene", sonar="seabat6012"), scene=SCENE))


def result_of(asked: Rerun, wish: Wanted) -> Tracked:
    """Ask for something and wait for it."""
    answered = threading.Event()

    def look() -> None:
        if asked.result_of == wish or asked.error:
            answered.set()

    stop = asked.listen(look)
    asked.ask(wish)
    look()
    assert answered.wait(280.0)
    stop()
    assert not asked.error
    assert asked.result is not None
    return asked.result


def run(state: State) -> list[Step]:
    data = open_data(state.data, state.scene, ())
    return list(Mission(state.tuning.mission()).steps(data.pings, data.poses))


def lists_of(result: Tracked) -> list[ObstacleList]:
    lists = [result.list_at(place) for place in range(len(result.t_s))]
    return [each for each in lists if each is not None]


@pytest.fixture(scope="module")
def direct() -> list[Step]:
    return run(START)


@pytest.fixture(scope="module")
def asked() -> Iterator[Rerun]:
    """An engine that has the detections of START."""
    made = Rerun(())
    result_of(made, wanted(START))
    yield made
    made.close()


@pytest.fixture(scope="module")
def result(asked: Rerun) -> Tracked:
    return result_of(asked, wanted(START))


def test_lists_are_those_of_a_mission(result: Tracked, direct: list[Step]) -> None:
    assert lists_of(result) == [step.list for step in direct]


def test_a_slider_of_the_tracker_needs_no_chain(direct: list[Step], monkeypatch: pytest.MonkeyPatch) -> None:
    moved = apply(START, do.SetSetting("tracker.life.confirm_echoes", 6))
    expected, runs = run(moved), MissionRuns(())
    runs(whole, wanted(START))
    monkeypatch.setattr(rerun, "Detecting", None)  # whoever makes another chain fails
    result = runs(whole, wanted(moved))
    assert result is not None
    assert lists_of(result) == [step.list for step in expected]
    assert [step.list for step in expected] != [step.list for step in direct]


def test_another_chain_finds_anew(direct: list[Step]) -> None:
    last = len(START.tuning.config.pipeline.chain()) - 1
    moved = apply(START, do.SetSetting(f"pipeline.stage[{last}].high", 100.0))
    engine = Rerun(())
    engine.ask(wanted(START))
    assert lists_of(result_of(engine, wanted(moved))) == [step.list for step in run(moved)]
    assert engine.result is not None
    assert lists_of(engine.result) != [step.list for step in direct]
    engine.close()


def test_arrays_say_what_the_lists_say(result: Tracked, direct: list[Step]) -> None:
    reported = {(place, obstacle.id): obstacle for place, step in enumerate(direct) for obstacle in step.list.obstacles}
    assert sum(len(course.place) for course in result.courses) == len(reported)
    for course in result.courses:
        for k, place in enumerate(course.place.tolist()):
            obstacle = reported[place, course.id]
            assert tuple(course.position[k]) == obstacle.position_ned
            assert tuple(course.sigma_velocity[k]) == obstacle.sigma_velocity
            assert course.t_s[k] == pytest.approx((direct[place].ping.t_ns - direct[0].ping.t_ns) / 1e9)


def test_way_and_truth_are_the_scenes(result: Tracked) -> None:
    boat = next(truth for truth in result.truths if truth.name == "boat")
    there = np.array([40.0, -9.0, 0.0]) + boat.t_s[:, None] * (-0.5, 0.4, 0.0)
    np.testing.assert_allclose(boat.position, there, atol=1e-9)
    np.testing.assert_allclose(result.path[:, 0], 0.6 * result.t_s, atol=1e-6)
    assert result.heading(0) == pytest.approx(0.0)
    border = result.outline(len(result.t_s) - 1)
    assert border[0] == pytest.approx(result.path[-1])
    assert result.sector is not None
    assert np.hypot(*(border[1:, :2] - result.path[-1, :2]).T) == pytest.approx(result.sector.range_max_m)


def test_an_object_is_tentative_from_its_first_echo_until_it_is_listed(result: Tracked) -> None:
    for course in result.courses:
        first, second = course.lives()[:2]
        assert (first.state, second.state) == (TENTATIVE, ACTIVE)
        assert first.from_s == pytest.approx(course.first_seen_s)
        assert first.to_s == second.from_s == course.t_s[0]


def test_accuracy_by_hand(result: Tracked, direct: list[Step]) -> None:
    """The last list: both objects active, one track each, so GOSPA is the root of the sum of squared distances."""
    last = direct[-1].list.obstacles
    assert [obstacle.state for obstacle in last] == ["active", "active"]
    truths = [truth.position[-1, :2] for truth in result.truths]
    nearest = [min(np.hypot(*(np.array(each.position_ned[:2]) - at)) for each in last) for at in truths]
    assert result.gospa_m[-1] == pytest.approx(float(np.hypot(*nearest)))
    assert {score.name for score in result.scores} == {"rock", "boat"}
    assert not result.false_ids
    for course in result.courses:
        truth = result.truth_of(course.id)
        assert truth is not None
        assert np.hypot(*(truth.position[-1, :2] - course.position[-1, :2])) < 2.0


def test_what_rests_is_in_the_map_afterwards(result: Tracked) -> None:
    for item in result.at_rest:
        truth = result.truth_of(item.id)
        assert truth is None or truth.name == "rock"


def test_a_run_that_is_overtaken_is_given_up() -> None:
    began, results = threading.Event(), []
    engine = Rerun(())

    def look() -> None:
        if engine.progress and engine.progress.done:
            began.set()
        if engine.result_of is not None:
            results.append(engine.result_of)

    engine.listen(look)
    engine.ask(wanted(START))
    assert began.wait(280.0)
    later = wanted(apply(START, do.SetSetting("tracker.life.confirm_echoes", 4)))
    result_of(engine, later)
    engine.close()
    assert all(each == later for each in results)


@pytest.mark.parametrize(
    ("reference", "word"),
    [(DataReference(), "no data"), (DataReference(kind="file", path="/etc/passwd"), "folder")],
)
def test_what_cannot_be_tracked_is_said_in_one_line(reference: DataReference, word: str) -> None:
    engine, failed = Rerun(()), threading.Event()
    engine.listen(lambda: failed.set() if engine.error else None)
    engine.ask(Wanted(reference, None, START.tuning.mission()))
    assert failed.wait(10.0)
    engine.close()
    assert word in engine.error
    assert "\n" not in engine.error
    assert engine.progress is None


def test_a_scene_matters_only_where_the_data_are_its_own() -> None:
    longer = SCENE | {"duration_s": 9.0}
    file = msgspec.structs.replace(START, data=DataReference(kind="file", path="a.npz"))
    other = msgspec.structs.replace(file, scene=scene_of(longer))
    assert wanted(file) == wanted(other)
    assert wanted(START) != wanted(msgspec.structs.replace(START, scene=scene_of(longer)))


def test_a_track_is_called_by_its_number_and_the_object_that_it_stood_for(result: Tracked) -> None:
    for course in result.courses:
        truth = result.truth_of(course.id)
        assert truth is not None
        assert result.name_of(course.id) == f"track {course.id} ({truth.name})"
    assert replace(result, false_ids=frozenset({9})).name_of(9) == "track 9 (false)"
    assert replace(result, false_ids=frozenset({9}), truths=()).name_of(9) == "track 9"  # nothing is known
    assert result.name_of(8) == "track 8"
