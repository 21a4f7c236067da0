"""Observer, association and all settings of the tracker, as the observer's menu shows them."""

from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from ods.tracker.association.registry import ASSOCIATIONS
from ods.tracker.observer.registry import OBSERVERS
from ods.workbench.model.actions import SetSetting
from ods.workbench.model.paths import value_at
from ods.workbench.session import Session
from ods.workbench.web.follow import follow


def settings_panel(session: Session) -> None:
    """Build the controls."""
    _choice(session, "tracker.observer", "observer", sorted(OBSERVERS))
    _choice(session, "tracker.association", "association", sorted(ASSOCIATIONS))


def _choice(session: Session, path: str, label: str, names: list[str]) -> None:
    def chosen(event: ValueChangeEventArguments[str]) -> None:
        if event.value != value_at(session.state.tuning.config, path):
            session.do(SetSetting(path, event.value))

    select = ui.select(names, value=value_at(session.state.tuning.config, path), label=label, on_change=chosen)
    select.classes("w-full").props("dense options-dense").mark(path)
    follow(session, select, lambda _, after: select.set_value(value_at(after.tuning.config, path)))
