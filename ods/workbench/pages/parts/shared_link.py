"""A state in the link's fragment, which browsers keep to themselves: taken over when a page is opened by it."""

from nicegui import ui

from ods.workbench.model.actions import SetState
from ods.workbench.model.share import shared_text, state_of
from ods.workbench.session import Session

MARK = "#state="
TAKEN = "const hash = location.hash; if (hash) history.replaceState(null, '', location.pathname); return hash"


def link_of(session: Session) -> str:
    """Return the end of a link that shows all as it is now."""
    return MARK + shared_text(session.state)


def take(session: Session, text: str) -> None:
    """Show what a link says, whatever stands before its mark. Raises ShareError."""
    state = state_of(text.strip().rpartition(MARK)[2], session.state)
    session.do(SetState(state, "what was shared"))


def take_when_opened(session: Session) -> None:
    """Take over what the link of the page says, if it says something; the address bar forgets it."""

    async def look() -> None:
        fragment = await ui.run_javascript(TAKEN)
        if isinstance(fragment, str) and fragment.startswith(MARK):
            take(session, fragment)

    ui.timer(0.0, look, once=True)
