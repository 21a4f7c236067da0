"""Application of an action to a state: the only way that a state changes."""

from collections.abc import Callable, Iterable
from typing import Any

import msgspec

from ods.workbench.model import actions as do
from ods.workbench.model.chain import edits as chain_edits, numbers as chain_numbers
from ods.workbench.model.paths import PathError, tables_of, typed, with_value
from ods.workbench.model.scene import edits as scene_edits
from ods.workbench.model.state import Bookmark, Label, State, Tuning

STAGE = "pipeline.stage["
replace = msgspec.structs.replace


def apply(state: State, action: do.Action) -> State:
    """Return the state after an action; the one before is left as it is. Raises PathError, one line, for what cannot be
    done."""
    return _DOING[type(action)](state, action)


def _set(state: State, action: do.SetSetting) -> State:
    tuning = state.tuning
    if action.path.startswith(STAGE) and not tuning.config.pipeline.stage:
        tuning = chain_edits.edited(tuning, lambda _: None)  # the default chain, written out
    if action.path.startswith(STAGE) and action.path.count(".") == 2:
        return replace(state, tuning=_with_parameter(tuning, action))
    return replace(state, tuning=replace(tuning, config=with_value(tuning.config, action.path, action.value)))


def _with_parameter(tuning: Tuning, action: do.SetSetting) -> Tuning:
    """Return a tuning with a stage's parameter, which its table need not have had."""
    place, _, name = action.path.removeprefix(STAGE).partition("].")

    def change(entries: list[chain_edits.Entry]) -> None:
        if not (place.isdecimal() and int(place) < len(entries)):
            raise PathError(f"{action.path}: no such place in the chain")
        entries[int(place)][0][name] = action.value

    return chain_edits.edited(tuning, change)


def _set_scene(state: State, action: do.SetScene) -> State:
    return _with_scene(state, lambda scene: with_value(scene, action.path, action.value))


def _with_scene(state: State, change: Callable[[Any], Any]) -> State:
    if state.scene is None:
        raise PathError("scene: none is open")
    return replace(state, scene=change(state.scene))


def _open(state: State, action: do.OpenData) -> State:
    scene = state.scene if action.scene is None else scene_edits.scene_of(action.scene)
    if action.data.kind == "scene" and scene is None:
        raise PathError("scene: none is open")
    return replace(state, data=action.data, scene=scene, ping=0, bookmarks=(), labels=())


def _show_ping(state: State, action: do.ShowPing) -> State:
    return replace(state, ping=max(0, action.ping))


def _set_bookmark(state: State, action: do.SetBookmark) -> State:
    kept = [mark for mark in state.bookmarks if mark.ping != action.ping]
    if action.text:
        kept.append(typed({"ping": action.ping, "text": action.text}, Bookmark))
    return replace(state, bookmarks=tuple(sorted(kept, key=lambda mark: mark.ping)))


def _with_labels(state: State, labels: Iterable[Label]) -> State:
    """Return a state with labels, which are checked: there may be too many of them."""
    ordered = sorted(labels, key=lambda label: label.ping)
    return with_value(state, "labels", [tables_of(label) for label in ordered])


def _remove_label(state: State, action: do.RemoveLabel) -> State:
    if not 0 <= action.at < len(state.labels):
        raise PathError("label: no such label")
    return replace(state, labels=state.labels[: action.at] + state.labels[action.at + 1 :])


def _swap(state: State, _: do.SwapAB) -> State:
    if state.other is None:
        raise PathError("B is empty: keep a configuration as B first")
    return replace(state, tuning=state.other, other=state.tuning)


_DOING: dict[type[do.Action], Callable[[State, Any], State]] = {
    do.SetSetting: _set,
    do.AddStage: lambda state, a: replace(state, tuning=chain_edits.with_stage(state.tuning, a.use, a.at)),
    do.RemoveStage: lambda state, a: replace(state, tuning=chain_edits.without_stage(state.tuning, a.at)),
    do.MoveStage: lambda state, a: replace(state, tuning=chain_edits.with_stage_moved(state.tuning, a.at, a.to)),
    do.BypassStage: lambda state, a: replace(state, tuning=chain_edits.with_bypass(state.tuning, a.at, a.on)),
    do.WriteNumbers: lambda state, a: replace(state, tuning=chain_numbers.written(state.tuning, a.dr_m)),
    do.SetTuning: lambda state, a: replace(state, tuning=a.tuning),
    do.SetState: lambda _, a: a.state,
    do.KeepAsB: lambda state, _: replace(state, other=state.tuning),
    do.KeepAsNext: lambda state, _: replace(state, further=(*state.further[:1], state.tuning)),
    do.SwapAB: _swap,
    do.DropB: lambda state, _: replace(state, other=None, further=()),
    do.OpenData: _open,
    do.ShowBeside: lambda state, a: replace(state, beside=a.beside),
    do.ShowPing: _show_ping,
    do.SetView: lambda state, a: replace(state, view=with_value(state.view, a.name, a.value)),
    do.SetBookmark: _set_bookmark,
    do.AddLabel: lambda state, a: _with_labels(state, [*state.labels, a.label]),
    do.RemoveLabel: _remove_label,
    do.SetLabels: lambda state, a: _with_labels(state, a.labels),
    do.SetScene: _set_scene,
    do.AddObject: lambda state, a: _with_scene(
        state, lambda scene: scene_edits.with_object(scene, a.shape, a.position_ned)
    ),
    do.CopyObject: lambda state, a: _with_scene(state, lambda scene: scene_edits.with_copy(scene, a.at, a.moved_ned)),
    do.RemoveObject: lambda state, a: _with_scene(state, lambda scene: scene_edits.without_object(scene, a.at)),
    do.AddWaypoint: lambda state, a: _with_scene(
        state, lambda scene: scene_edits.with_waypoint(scene, a.of, a.t_s, a.position_ned)
    ),
    do.RemoveWaypoint: lambda state, a: _with_scene(
        state, lambda scene: scene_edits.without_waypoint(scene, a.of, a.at)
    ),
}
