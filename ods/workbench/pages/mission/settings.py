"""Observer, association and all settings of the tracker, as the observer's menu shows them."""

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import groupby
from typing import Any

from nicegui import ui

from ods.tracker.association.registry import ASSOCIATIONS
from ods.tracker.observer.registry import OBSERVERS
from ods.tracker.settings import TrackerSettings
from ods.workbench.model.actions import SetSetting
from ods.workbench.model.paths import tables_of, value_at
from ods.workbench.model.sliders import Control, controls_of
from ods.workbench.model.state import State
from ods.workbench.pages.parts.control_row import ControlRow
from ods.workbench.session import Session
from ods.workbench.web.follow import follow

ROOT = "tracker."
ALONE = frozenset({"plugins", "map.path", "map.position_sigma_m", "map.minimum_times_seen", "resume_within_s"})
"""Of the vehicle's computer only: they change nothing of a mission that is tracked again."""
TITLES = {
    "": "Approach", "motion": "Motion", "echo": "Echoes", "life": "Lives", "planner": "To the planner",
    "bottom": "Bottom", "surface": "Surface", "clearance": "Clearance",
}  # fmt: skip
UNFOLDED = frozenset({"", "life"})


def settings_panel(session: Session) -> None:
    """Build a row for each setting, in groups that can be folded."""
    rows: dict[str, ControlRow] = {}
    for group, controls in groups():
        with ui.expansion(TITLES.get(group, group), value=group in UNFOLDED) as fold:
            fold.style("--nicegui-default-padding: 0.25rem; --nicegui-default-gap: 0")
            fold.classes("w-full").props("dense dense-toggle header-class=font-medium").mark(f"group {group}")
            for control in controls:
                path = ROOT + control.path
                value = value_at(session.state.tuning.config, path)
                rows[path] = ControlRow(control, value, partial(_set, session, rows, path))

    def changed(before: State, after: State) -> None:
        old, new = (tables_of(state.tuning.config.tracker) for state in (before, after))
        if old != new:
            for path, row in rows.items():
                row.show(value_at(after.tuning.config, path))

    follow(session, fold, changed)


def groups() -> list[tuple[str, Sequence[Control]]]:
    """Return the controls of each table of the tracker's settings, by its name."""
    names: Mapping[str, Sequence[str]] = {"observer": sorted(OBSERVERS), "association": sorted(ASSOCIATIONS)}
    controls = [each for each in controls_of(TrackerSettings, names) if each.path not in ALONE]
    return [(group, list(found)) for group, found in groupby(controls, lambda each: each.path.rpartition(".")[0])]


def _set(session: Session, rows: dict[str, ControlRow], path: str, value: Any) -> None:
    """Set it; what cannot be is shown as it was, and the page says why."""
    try:
        session.do(SetSetting(path, value))
    finally:
        rows[path].show(value_at(session.state.tuning.config, path))
