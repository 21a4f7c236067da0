"""Whatever is done can be undone and done again; equal actions give equal states."""

import msgspec
import pytest
from hypothesis import given, strategies as st

from ods.sim_sonar.scene.settings import SceneFile, Sphere, VehiclePath
from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.history import LONGEST, History
from ods.workbench.model.paths import PathError
from ods.workbench.model.state import DataReference, State, Tuning, View

SCENE = SceneFile(
    seed=1,
    vehicle=VehiclePath(position_ned=(0.0, 0.0, 5.0)),
    objects=[Sphere(name="rock", radius_m=1.0, position_ned=(20.0, 0.0, 5.0), velocity_ned=(0.5, 0.0, 0.0))],
)
START = State(scene=SCENE, data=DataReference(kind="scene"))
CHAIN = START.tuning.config.pipeline.chain()
LAST = len(CHAIN) - 1
ACTIONS: tuple[do.Action, ...] = (
    do.SetSetting(f"pipeline.stage[{LAST}].high", 7.0),
    do.SetSetting(f"pipeline.stage[{LAST}].high", 8.0),
    do.SetSetting("tracker.observer", "independent"),
    do.SetSetting("tracker.observer", "no such"),
    do.SetSetting("pipeline.stage[99].high", 7.0),
    do.AddStage("filter.median", 1),
    do.AddStage("filter.median", 99),
    do.AddStage("no such", 0),
    do.RemoveStage(0),
    do.RemoveStage(LAST),
    do.MoveStage(0, 1),
    do.BypassStage(0, True),
    do.BypassStage(0, False),
    do.BypassStage(LAST, True),
    do.SetTuning(Tuning(), "preset default"),
    do.SetState(State(tuning=Tuning(bypassed=(1,)), scene=SCENE), "preset mine"),
    do.KeepAsB(),
    do.KeepAsNext(),
    do.SwapAB(),
    do.DropB(),
    do.ShowPing(12),
    do.SetView("palette", "gray"),
    do.SetView("palette", "mud"),
    do.SetBookmark(3, "here"),
    do.SetBookmark(3, ""),
    do.SetScene("objects[0].radius_m", 2.0),
    do.AddObject("plane", (30.0, 5.0, 5.0)),
    do.CopyObject(0, (0.0, 5.0, 0.0)),
    do.RemoveObject(0),
    do.AddWaypoint("objects[0]", 10.0, (25.0, 3.0, 5.0)),
    do.RemoveWaypoint("objects[0]", 0),
    do.OpenData(DataReference(kind="file", path="a.npz")),
)


def _after(history: History, action: do.Action) -> History:
    try:
        return history.after(action)
    except PathError:
        return history


@given(st.lists(st.sampled_from(ACTIONS), max_size=25))
def test_all_that_was_done_is_undone_and_done_again(actions: list[do.Action]) -> None:
    history = History.of(START)
    for action in actions:
        history = _after(history, action)
    end = history.state
    while history.undoes:
        history = history.undone()
    assert _but_ping(history.state) == _but_ping(START)
    while history.redoes:
        history = history.redone()
    assert _but_ping(history.state) == _but_ping(end)


def _but_ping(state: State) -> State:
    """The ping that is shown is no step."""
    return msgspec.structs.replace(state, ping=0)


@given(st.lists(st.sampled_from(ACTIONS), max_size=25))
def test_the_steps_of_a_history_done_again_give_its_state(actions: list[do.Action]) -> None:
    history = History.of(START)
    for action in actions:
        history = _after(history, action)
    written = [msgspec.json.decode(msgspec.json.encode(action), type=do.Step) for action in history.actions()]
    again = START
    for action in written:
        again = apply(again, action)
    assert _but_ping(again) == _but_ping(history.state)


def test_a_slider_that_is_dragged_is_one_step_with_both_ends_in_its_name() -> None:
    history = History.of(START)
    for high in (6.0, 6.5, 7.0):
        history = history.after(do.SetSetting(f"pipeline.stage[{LAST}].high", high))
    assert [step.name for step in history.steps] == ["start", "detect.two_level: high level 5.5 → 7"]
    assert history.undone().state == START


def test_another_ping_is_no_step_and_keeps_what_can_be_redone() -> None:
    history = History.of(START).after(do.AddStage("filter.median", 1)).undone()
    history = history.after(do.ShowPing(5))
    assert history.redoes == "add filter.median"
    assert history.redone().state.ping == 5


def test_only_so_many_steps_are_kept() -> None:
    history = History.of(START)
    for number in range(LONGEST + 10):
        history = history.after(do.SetBookmark(number, "mark"))
    assert len(history.steps) == LONGEST
    assert len(history.state.bookmarks) == LONGEST + 10


@pytest.mark.parametrize(
    ("action", "complaint"),
    [
        (do.SetSetting("tracker.observer", 3), "tracker.observer: expected a string, got an integer"),
        (do.SetSetting("tracker.observers", "x"), "tracker.observers: no such setting"),
        (do.SetSetting(f"pipeline.stage[{LAST}].hihg", 3.0), "hihg"),
        (do.BypassStage(LAST, True), "the stage that detects cannot be bypassed"),
        (do.RemoveObject(4), r"objects\[4\]: no such object"),
        (do.RemoveWaypoint("vehicle", 0), r"vehicle.waypoints\[0\]: no such way-point"),
        (do.SwapAB(), "B is empty"),
    ],
)
def test_what_cannot_be_done_is_one_line_that_names_the_key(action: do.Action, complaint: str) -> None:
    with pytest.raises(PathError, match=complaint):
        apply(START, action)


@pytest.mark.parametrize(
    ("name", "value", "called"),
    [
        ("marked_obstacle", 2, "marked track 2"), ("marked_obstacle", None, "no marked track"),
        ("dark", False, "light"), ("attention", True, "show attention"), ("presentation", "polar", "show as polar"),
        ("lowest_db", -10.0, "colours from dB -10"),
    ],
)  # fmt: skip
def test_what_is_shown_otherwise_has_a_name(name: str, value: object, called: str) -> None:
    start = msgspec.structs.replace(State(), view=View(marked_obstacle=1))
    assert History.of(start).after(do.SetView(name, value)).undoes == called
