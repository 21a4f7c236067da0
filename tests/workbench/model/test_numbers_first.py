"""Numbers that follow from the smallest object: shown as they run, and not changed by a change of another one."""

from functools import reduce
from typing import Any

import msgspec
import pytest

from ods.offline.mission import MissionSettings
from ods.pipeline.settings import PipelineSettings
from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.chain.numbers import follows, numbered
from ods.workbench.model.chain.numbers_first import with_numbers_first
from ods.workbench.model.history import History
from ods.workbench.model.state import State, Tuning

DR_M = 0.05
TAPS = do.SetSetting("pipeline.stage[3].taps", 7)


def state_of(**pipeline: Any) -> State:
    return State(Tuning(config=msgspec.convert({"pipeline": pipeline}, MissionSettings)))


def runs(state: State) -> PipelineSettings:
    """What a ping goes through."""
    return state.tuning.pipeline().at_spacing(DR_M)


def after(state: State, action: do.Action) -> State:
    return reduce(apply, with_numbers_first(state, action, DR_M), state)


@pytest.mark.parametrize("pipeline", [{}, {"smallest_object_m": 1.0}, {"attention": {"subsample": 3}}])
def test_the_numbers_reported_are_those_that_run(pipeline: dict[str, Any]) -> None:
    state = state_of(**pipeline)
    assert numbered(state.tuning, DR_M) == runs(state).stage


@pytest.mark.parametrize("pipeline", [{}, {"smallest_object_m": 1.0}])
def test_a_number_that_is_set_changes_no_other(pipeline: dict[str, Any]) -> None:
    before = runs(state_of(**pipeline))
    now = runs(after(state_of(**pipeline), TAPS))
    assert now.attention == before.attention
    changed = [one for one, other in zip(now.stage, before.stage, strict=True) if one != other]
    assert changed == [before.stage[3] | {"taps": 7}]


@pytest.mark.parametrize(
    "action",
    [do.BypassStage(3, on=True), do.RemoveStage(3), do.AddStage("filter.median", 4)],
    ids=lambda each: type(each).__name__,
)
def test_another_chain_keeps_the_numbers(action: do.Action) -> None:
    before, now = runs(state_of()), runs(after(state_of(), action))
    assert now.attention == before.attention
    assert now.stage[-1] == before.stage[-1]


def test_what_lets_numbers_follow_comes_alone() -> None:
    for action in (do.SetSetting("pipeline.stage[4].high", 6.0), do.BypassStage(0, on=True), do.MoveStage(0, 1)):
        assert with_numbers_first(state_of(), action, DR_M) == (action,)


def test_what_is_refused_comes_alone() -> None:
    wrong = do.SetSetting("pipeline.stage[3].taps", 8)
    assert with_numbers_first(state_of(), wrong, DR_M) == (wrong,)


def test_a_stage_bypassed_where_a_smallest_object_is_set_leaves_a_chain() -> None:
    state = apply(state_of(smallest_object_m=1.0), do.BypassStage(3, on=True))
    assert not follows(state.tuning)
    assert state.tuning.pipeline().smallest_object_m == 0.0
    assert apply(state, do.BypassStage(3, on=False)).tuning.pipeline().smallest_object_m == 1.0


def test_both_are_steps_of_the_history() -> None:
    history = History.of(state_of())
    for action in with_numbers_first(history.state, TAPS, DR_M):
        history = history.after(action)
    assert [step.name for step in history.steps] == [
        "start",
        "numbers of samples 0.05 m apart",
        "filter.fir: filter length 5 → 7",
    ]
    assert history.undone().undone().state == state_of()
