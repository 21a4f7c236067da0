"""Computations of the image processing menu, in a thread of its own: the newest request only."""

import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from ods.base.computer.resident import release_freed_memory
from ods.base.errors import OdsError, one_line
from ods.base.frames.mounting import Mounting
from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.engine.background.newest import Newest
from ods.workbench.engine.data import Data, open_data
from ods.workbench.engine.ping.analysis import Cost, OvertakenError, PingAnalysis, PingAnalyzer
from ods.workbench.engine.ping.compare import Difference, difference
from ods.workbench.engine.ping.labels import judged_by, of_ping
from ods.workbench.engine.ping.truth import Judged, TrueCircle, judged, true_circles
from ods.workbench.model.state import DataReference, State, Tuning
from ods.workbench.session import Session

IDLE_S = 1.0
"""After that memory is given back; not while one drags a slider."""
REST_S = 0.1
"""After a picture, until it is drawn, nothing else is computed."""


class Opened(NamedTuple):
    """Data that are open."""

    key: Any
    data: Data
    analyzer: PingAnalyzer


@dataclass(frozen=True, eq=False)
class Answer:
    """What came of one state."""

    state: State
    data: Data
    place: int
    a: PingAnalysis
    b: PingAnalysis | None
    parted: Difference | None
    """Of A's and B's detections."""
    true: Sequence[TrueCircle] | None
    """Objects that are there, or what a person labelled; None: not known, or not to be shown."""
    judged_a: Judged | None
    """A's detections against them."""
    judged_b: Judged | None
    beside: PingAnalysis | None = None
    """Of other data, by A."""
    further: Sequence[PingAnalysis | None] = ()
    """C and D; none: it cannot be."""
    complaint: str = ""
    """Why there is no B, C or D."""


Costs = Sequence[tuple[str, Cost]]
"""Of A alone, unnamed, or of A and B."""


class AnswerListener(Protocol):
    """Receiver of the answers, in a thread."""

    def answered_with(self, answer: Answer) -> None:
        """Take what came."""

    def costed(self, costs: Costs, period_s: float | None) -> None:
        """Take what the chains of the last answer cost; period_s: of the pings."""

    def failed(self, why: str) -> None:
        """Take why nothing came, one line."""


class Work:
    """Answers the session's newest state. Waits while the page is not shown (`visible`), and then does what was asked
    last. What a chain costs is found once it is answered, unless something else is asked."""

    def __init__(self, session: Session, listener: AnswerListener) -> None:
        self._session = session
        self._opened: Opened | None = None
        self._beside: Opened | None = None
        self._listener = listener
        self._lock = threading.Lock()
        self.asked, self.answered = 0, 0
        """Numbers of requests; equal when nothing is computed."""
        self._newest: Newest[tuple[int, State], Answer] = Newest(
            self._answer, self._tell, self._fail, idle=release_freed_memory, idle_s=IDLE_S
        )
        self._visible, self._waits = True, False
        self.held = False
        """Whether the timeline is dragged just now: pictures only, and no costs."""
        self._since = 0.0
        self._stop = session.listen(self._follow)

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
        """Return whether something is computed, and nothing has come for longer than that."""
        return self.asked != self.answered and time.monotonic() - self._since > limit_s

    def ask(self) -> None:
        """Compute what the session's state says."""
        self._waits = not self._visible
        if self._visible:
            with self._lock:
                if self.asked == self.answered:  # otherwise it was shown when the last came
                    self._since = time.monotonic()
                self.asked += 1
                self._newest.ask((self.asked, self._session.state))

    def hold(self, held: bool) -> None:
        """Begin to answer with pictures only; when it ends, what the last one left out comes with it once more."""
        ends, self.held = self.held and not held, held
        if ends:
            self.ask()

    def close(self) -> None:
        """End the thread."""
        self._stop()
        self._newest.close()

    def _follow(self, before: State, after: State) -> None:
        if wanted(before) != wanted(after):
            self.ask()

    def _answer(self, request: tuple[int, State]) -> Answer:
        _, state = request
        opened = self._open(state)
        place = min(state.ping, len(opened.data.pings) - 1)
        others = [*([] if state.other is None else [state.other]), *state.further]
        a = opened.analyzer.analyze(state.tuning.mission(), place, 1 + len(others))
        kept, complaints = [], []
        for name, tuning in zip("BCD", others, strict=False):
            analysis, why = _analyze(opened.analyzer, tuning, place, 1 + len(others))
            kept.append(analysis)
            complaints.append(why and f"{name}: {why}")
        b = kept[0] if kept else None
        parted = None if b is None else difference(a.detections.detections, b.detections.detections)
        true = self._true(state, opened.data, place)
        judged_a, judged_b = (
            None if true is None or each is None else judged(each.detections, true) for each in (a, b)
        )
        labels = [label for _, label in of_ping(state.labels, place, a.ping)]
        if true is None and labels and state.view.truth:
            true, judged_a = judged_by(a.detections, labels, a.ping)
            judged_b = None if b is None else judged_by(b.detections, labels, b.ping)[1]
        beside, why = self._analysis_beside(state)
        complaint = "; ".join(filter(None, (*complaints, why)))
        return Answer(state, opened.data, place, a, b, parted, true, judged_a, judged_b, beside, kept[1:], complaint)

    def _analysis_beside(self, state: State) -> tuple[PingAnalysis | None, str]:
        """Return the ping of the other data at the same place, or their last, and why there is none."""
        wanted, self._beside = state.beside, self._beside if state.beside else None
        if wanted is None:
            return None, ""
        try:
            self._beside = self._opening(self._beside, wanted.data, wanted.scene)
            data, analyzer = self._beside.data, self._beside.analyzer
            return analyzer.analyze(state.tuning.mission(), min(state.ping, len(data.pings) - 1)), ""
        except OvertakenError:
            raise
        except OdsError as error:
            return None, f"beside it: {error}"

    def _true(self, state: State, data: Data, place: int) -> Sequence[TrueCircle] | None:
        truth = data.truth(place) if state.view.truth else None
        return None if truth is None else true_circles(truth, Mounting(state.tuning.config.mounting))

    def _open(self, state: State) -> Opened:
        self._opened = self._opening(self._opened, state.data, state.scene)
        return self._opened

    def _opening(self, opened: Opened | None, reference: DataReference, scene: SceneFile | None) -> Opened:
        """Return data that are open, if these are the ones, or open them."""
        key = reference, scene if reference.kind == "scene" else None
        if opened is not None and opened.key == key:
            return opened
        data = open_data(reference, scene, self._session.folders)
        return Opened(key, data, PingAnalyzer(data, lambda: self._newest.overtaken))

    def _tell(self, request: tuple[int, State], answer: Answer) -> None:
        self.answered, self._since = request[0], time.monotonic()
        self._listener.answered_with(answer)
        self._tell_costs(answer)

    def _tell_costs(self, answer: Answer) -> None:
        opened, state = self._opened, answer.state
        if opened is None or self.held or not self._newest.rests(REST_S):
            return
        chains = [("A" if answer.b else "", state.tuning), *([("B", state.other)] if answer.b and state.other else [])]
        costs = []
        for who, tuning in chains:
            cost = opened.analyzer.cost(tuning.mission(), answer.place, lambda: self._newest.overtaken)
            if cost is None:
                return
            costs.append((who, cost))
        self._listener.costed(costs, answer.data.period_s)

    def _fail(self, request: tuple[int, State], error: Exception) -> None:
        if isinstance(error, OvertakenError):
            return
        self.answered = request[0]
        why = str(error) if isinstance(error, OdsError) else f"{type(error).__name__}: {one_line(error)}"
        self._listener.failed(why)


def _analyze(analyzer: PingAnalyzer, tuning: Tuning, place: int, shown: int) -> tuple[PingAnalysis | None, str]:
    """Return what a chain makes of a ping, or why it cannot."""
    try:
        return analyzer.analyze(tuning.mission(), place, shown), ""
    except OvertakenError:
        raise
    except OdsError as error:
        return None, str(error)


def wanted(state: State) -> tuple[Any, ...]:
    """Return what of a state an answer depends on."""
    view = state.view
    scene = state.scene if state.data.kind == "scene" else None
    return (
        state.tuning, state.other, state.further, state.data, scene, state.ping, state.beside, view.shown_stage,
        view.compared_stage, view.comparison, view.truth, state.labels, view.lowest_db, view.highest_db,
    )  # fmt: skip


def last_stage(tuning: Tuning) -> tuple[int, dict[str, Any]]:
    """Return place and table of the stage that detects."""
    chain = tuning.config.pipeline.chain()
    return len(chain) - 1, chain[-1]
