"""A menu that says how often it was built."""

from nicegui import ui

from ods.base.errors import OdsError
from ods.workbench.session import Session

KEYS = (("K", "what this menu's key does"),)
built: list[int] = []


def build(session: Session) -> None:
    built.append(session.number)
    ui.label(f"built {len(built)}")

    def fail() -> None:
        raise OdsError("that cannot be\ndone")

    ui.button("fail", on_click=fail)
