"""Names of actions in the history."""

import re
from collections.abc import Callable
from typing import Any

from ods.base.settings import Settings
from ods.workbench.model import actions as do
from ods.workbench.model.apply import STAGE
from ods.workbench.model.paths import PathError, value_at
from ods.workbench.model.state import State
from ods.workbench.model.words import called

LONGEST_VALUE = 24
AXES = ("north", "east", "down")
AXIS = re.compile(r"(\w+_ned)\[([0-2])\]")
WAYPOINT = re.compile(r"waypoints\[(\d+)\]")
OBJECT = re.compile(r"objects\[(\d+)\]")


def name_of(action: do.Action, before: State) -> str:
    """Return the name of an action on a state: "filter.fir: filter length 9 → 15"."""
    return _NAMES[type(action)](action, before)


def _set(action: do.SetSetting, before: State) -> str:
    chain = before.tuning.config.pipeline.chain()
    place, _, name = action.path.removeprefix(STAGE).partition("].")
    if action.path.startswith(STAGE) and place.isdecimal() and int(place) < len(chain):
        stage = chain[int(place)]
        return f"{stage['use']}: {_changed(name, stage.get(name), action.value)}"
    of, _, name = action.path.rpartition(".")
    change = _changed(name, _value(before.tuning.config, action.path), action.value)
    return f"{' '.join(called(part).name for part in of.split('.'))}: {change}" if of else change


def _set_scene(action: do.SetScene, before: State) -> str:
    of, _, last = action.path.rpartition(".")
    axis = AXIS.fullmatch(last)
    name = f"{called(axis[1]).name} {AXES[int(axis[2])]}" if axis else called(last).name
    change = _change(_value(before.scene, action.path), action.value)
    unit = called(axis[1] if axis else last).unit
    part = _part(before, of)
    return " ".join(filter(None, (f"{part}:" if part else "scene:", name, change, unit)))


def _part(before: State, of: str) -> str:
    """Return what a part of the scene is called: an object by its name."""
    found = OBJECT.match(of)
    scene = before.scene
    if found and scene is not None and int(found[1]) < len(scene.objects):
        of = of.replace(found[0], scene.objects[int(found[1])].name, 1)
    of = WAYPOINT.sub(lambda place: f"way-point {int(place[1]) + 1}", of)
    return of.replace("_", " ").replace(".", ", ")


def _changed(field: str, old: Any, new: Any) -> str:
    name, unit = called(field)
    return " ".join(filter(None, (name, _change(old, new), unit)))


def _value(settings: Settings | None, path: str) -> Any:
    try:
        return None if settings is None else value_at(settings, path)
    except PathError:
        return None


def _change(old: Any, new: Any) -> str:
    return f"= {_short(new)}" if old is None else f"{_short(old)} → {_short(new)}"


def _short(value: Any) -> str:
    if isinstance(value, list | tuple):
        text = f"({', '.join(map(_short, value))})"
    else:
        text = f"{value:.4g}" if isinstance(value, float) else str(value)
    return text if len(text) <= LONGEST_VALUE else f"{text[: LONGEST_VALUE - 1]}…"


def _view(action: do.SetView, _: State) -> str:
    words = _VIEW.get(action.name, f"view {action.name}")
    if isinstance(action.value, bool):
        return words[not action.value] if isinstance(words, tuple) else f"{words} {'on' if action.value else 'off'}"
    return f"no {words}" if action.value is None else f"{words} {_short(action.value)}"


_VIEW: dict[str, str | tuple[str, str]] = {
    "presentation": "show as", "shown_stage": "picture after place", "compared_stage": "beside it after place",
    "comparison": "compare by", "palette": "colours", "lowest_db": "colours from dB", "highest_db": "colours to dB",
    "large": "large pictures", "echogram_beam": "single beam in the echogram", "echogram_layers": "echogram with",
    "truth": ("show truth", "hide truth"),
    "attention": ("show attention", "hide attention"), "pinned_beam": "pinned beam", "marked_obstacle": "marked track",
    "dark": ("dark", "light"), "chain_px": "width of the chain, pixels",
}  # fmt: skip
"""What a field of View is called; of a switch both."""


def _stage(before: State, at: int) -> str:
    return str(before.tuning.config.pipeline.chain()[at]["use"])


def _object(before: State, at: int) -> str:
    return before.scene.objects[at].name if before.scene else ""


_NAMES: dict[type[do.Action], Callable[[Any, State], str]] = {
    do.SetSetting: _set,
    do.AddStage: lambda a, _: f"add {a.use}",
    do.RemoveStage: lambda a, before: f"remove {_stage(before, a.at)}",
    do.MoveStage: lambda a, before: f"move {_stage(before, a.at)} to {a.to + 1}",
    do.BypassStage: lambda a, before: f"{'bypass' if a.on else 'use'} {_stage(before, a.at)}",
    do.WriteNumbers: lambda a, _: f"numbers of samples {a.dr_m:.4g} m apart",
    do.SetTuning: lambda a, _: a.name,
    do.SetState: lambda a, _: a.name,
    do.KeepAsB: lambda _, __: "keep as B",
    do.KeepAsNext: lambda _, before: f"keep as {'D' if before.further else 'C'}",
    do.SwapAB: lambda _, __: "swap A and B",
    do.DropB: lambda _, __: "drop B",
    do.OpenData: lambda a, _: f"open {a.data.path or a.data.kind}",
    do.ShowBeside: lambda a, _: f"beside it {a.beside.data.path}" if a.beside else "nothing beside it",
    do.ShowPing: lambda a, _: f"ping {a.ping}",
    do.SetView: _view,
    do.SetBookmark: lambda a, _: f"bookmark {a.text}" if a.text else "remove bookmark",
    do.AddLabel: lambda a, _: " ".join(filter(None, ("label", a.label.text, f"in ping {a.label.ping}"))),
    do.RemoveLabel: lambda _, __: "remove label",
    do.SetLabels: lambda a, _: a.name,
    do.SetScene: _set_scene,
    do.AddObject: lambda a, _: f"add {a.shape}",
    do.CopyObject: lambda a, before: f"copy {_object(before, a.at)}",
    do.RemoveObject: lambda a, before: f"remove {_object(before, a.at)}",
    do.AddWaypoint: lambda a, _: f"way-point of {a.of} at {a.t_s:g} s",
    do.RemoveWaypoint: lambda a, _: f"remove way-point of {a.of}",
}
