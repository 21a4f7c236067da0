"""What the image processing menu computes, in a thread of its own: the newest request only."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ods.base.errors import OdsError, one_line
from ods.workbench.engine.compare import Difference, difference
from ods.workbench.engine.data import Data, open_data
from ods.workbench.engine.newest import Newest
from ods.workbench.engine.study import OvertakenError, Studio, Study
from ods.workbench.model.state import State, Tuning
from ods.workbench.session import Session


class Opened(NamedTuple):
    """Data that are open."""

    key: Any
    data: Data
    studio: Studio


@dataclass(frozen=True, eq=False)
class Answer:
    """What came of one state."""

    state: State
    data: Data
    place: int
    a: Study
    b: Study | None
    parted: Difference | None
    """Of A's and B's detections."""
    complaint: str = ""
    """Why there is no B."""


class Work:
    """Answers the newest state. Waits while nobody sees the page (`visible`), and then does what was asked last."""

    def __init__(self, session: Session, tell: Callable[[Answer], None], fail: Callable[[str], None]) -> None:
        """tell, fail: called in a thread; fail with one line."""
        self._session = session
        self._opened: Opened | None = None
        self._told, self._failed = tell, fail
        self._lock = threading.Lock()
        self.asked, self.answered = 0, 0
        """Numbers of requests; equal when nothing is computed."""
        self._newest: Newest[tuple[int, State], Answer] = Newest(self._answer, self._tell, self._fail)
        self._visible, self._waits = True, False
        self._since = 0.0

    @property
    def visible(self) -> bool:
        """Whether the page is seen."""
        return self._visible

    @visible.setter
    def visible(self, seen: bool) -> None:
        self._visible = seen
        if seen and self._waits:
            self.ask()

    def is_late(self, limit_s: float) -> bool:
        """Tell whether something has been computed for longer than that."""
        return self.asked != self.answered and time.monotonic() - self._since > limit_s

    def ask(self) -> None:
        """Compute what the session's state says."""
        self._waits = not self._visible
        if self._visible:
            with self._lock:
                if self.asked == self.answered:
                    self._since = time.monotonic()
                self.asked += 1
                self._newest.ask((self.asked, self._session.state))

    def close(self) -> None:
        """End the thread."""
        self._newest.close()

    def _answer(self, request: tuple[int, State]) -> Answer:
        _, state = request
        opened = self._open(state)
        place = min(state.ping, len(opened.data.pings) - 1)
        a = opened.studio.study(state.tuning.mission(), place)
        b, parted, complaint = None, None, ""
        if state.other is not None:
            try:
                b = opened.studio.study(state.other.mission(), place)
            except OvertakenError:
                raise
            except OdsError as error:
                complaint = f"B: {error}"
            else:
                parted = difference(a.detections.detections, b.detections.detections)
        return Answer(state, opened.data, place, a, b, parted, complaint)

    def _open(self, state: State) -> Opened:
        key = state.data, state.scene if state.data.kind == "scene" else None
        if self._opened is None or self._opened.key != key:
            data = open_data(state.data, state.scene, self._session.folders)
            self._opened = Opened(key, data, Studio(data, lambda: self._newest.overtaken))
        return self._opened

    def _tell(self, request: tuple[int, State], answer: Answer) -> None:
        self.answered = request[0]
        self._told(answer)

    def _fail(self, request: tuple[int, State], error: Exception) -> None:
        if isinstance(error, OvertakenError):
            return
        self.answered = request[0]
        self._failed(str(error) if isinstance(error, OdsError) else f"{type(error).__name__}: {one_line(error)}")


def wanted(state: State) -> tuple[Any, ...]:
    """Return what of a state an answer depends on."""
    view = state.view
    scene = state.scene if state.data.kind == "scene" else None
    return (
        state.tuning, state.other, state.data, scene, state.ping, view.shown_stage, view.compared_stage,
        view.comparison, view.lowest_db, view.highest_db,
    )  # fmt: skip


def last_stage(tuning: Tuning) -> tuple[int, dict[str, Any]]:
    """Return place and table of the stage that detects."""
    chain = tuning.config.pipeline.chain()
    return len(chain) - 1, chain[-1]
