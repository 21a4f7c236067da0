"""From the session and from threads to the widgets: always in NiceGUI's loop, and only while the widget lives."""

from collections.abc import Callable

from nicegui import core
from nicegui.element import Element

from ods.workbench.model.state import State
from ods.workbench.session import Session

PICTURE_FIRST_S = 0.05
"""After a change, until what may wait is shown: for that the browser goes through all of the page."""


def in_loop(element: Element, call: Callable[[], object], after_s: float = 0.0) -> None:
    """Call something soon in NiceGUI's loop and in the element's slot, unless the element is gone. From any thread.

    after_s: not before.
    """

    def run() -> None:
        if not element.is_deleted:
            with element:
                call()

    if core.loop is not None and not core.loop.is_closed():  # one that is about to run will do it, too
        core.loop.call_soon_threadsafe(*((core.loop.call_later, after_s, run) if after_s else (run,)))


def follow(session: Session, element: Element, changed: Callable[[State, State], object]) -> None:
    """Call `changed` with the state before and after each change, as `in_loop`, while the element lives."""

    def on_change(before: State, after: State) -> None:
        if element.is_deleted:
            stop()
        else:
            in_loop(element, lambda: changed(before, after))

    stop = session.listen(on_change)
    element.client.on_delete(stop)
