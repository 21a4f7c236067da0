"""One mission tracked again for each session: what it has outlives the page."""

from weakref import WeakKeyDictionary

from ods.workbench.engine.mission.rerun import Rerun
from ods.workbench.session import Session

_reruns: "WeakKeyDictionary[Session, Rerun]" = WeakKeyDictionary()


def rerun_of(session: Session) -> Rerun:
    """Return the one of a session: what it has outlives the page."""
    if session not in _reruns:
        _reruns[session] = Rerun(session.folders)
    return _reruns[session]
