"""The whole mission again, in a process of its own: chain and tracker as on board, what was found kept between runs."""

import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ods.base.errors import OdsError, one_line
from ods.base.frames.mounting import Mounting
from ods.config import part_of
from ods.messages import Ping
from ods.offline.mission import Detecting, Found, MissionSettings, Tracking
from ods.pipeline.settings import PipelineConfig
from ods.sim_sonar.scene.settings import SceneFile
from ods.tracker.map.map_object import MapObject
from ods.tracker.mission import MissionTracker
from ods.workbench.engine.background.listeners import Listeners
from ods.workbench.engine.background.newest import Newest
from ods.workbench.engine.background.own_process import OwnProcess
from ods.workbench.engine.data import Data, open_data
from ods.workbench.engine.mission.tracked import Beside, Collecting, Tracked
from ods.workbench.model.state import DataReference, State

PROGRESS_S = 0.1
"""Between two words about how far it is."""


class RerunError(OdsError):
    """The mission cannot be tracked; the text is one line."""


class Wanted(NamedTuple):
    """What is to be tracked, and how."""

    reference: DataReference
    scene: SceneFile | None
    """None where the data do not come from a scene."""
    settings: MissionSettings


class Progress(NamedTuple):
    """How far a run is."""

    done: int
    """Pings."""
    of: int
    detects: bool
    """The chain works on pings; otherwise what it found before is tracked again."""


def wanted(state: State) -> Wanted:
    """Return what a state asks for; two that are equal give the same result."""
    scene = state.scene if state.data.kind == "scene" else None
    return Wanted(state.data, scene, state.tuning.mission())


class Rerun:
    """Runs the newest wish, in a process of its own; one that is overtaken is given up. What came of it stays here."""

    def __init__(self, folders: Sequence[Path]) -> None:
        """folders: that files may be read from."""
        self.result: Tracked | None = None
        """The newest result."""
        self.result_of: Wanted | None = None
        """The request that `result` belongs to."""
        self.asked: Wanted | None = None
        self.error = ""
        """Why nothing came of what was asked for last; one line."""
        self.progress: Progress | None = None
        """None: nothing runs."""
        self._listeners: Listeners[[]] = Listeners()
        self._process = OwnProcess(MissionRuns(tuple(folders)))
        self._newest: Newest[Wanted, Tracked | None] = Newest(self._run, self._done, self._failed, self._process.end)

    def ask(self, wish: Wanted) -> None:
        """Run this, instead of what runs or waits, unless it was asked for last."""
        if wish != self.asked:
            self.asked, self.error, self.progress = wish, "", Progress(0, 0, True)
            self._newest.ask(wish)
            self._listeners.notify()

    def listen(self, changed: Callable[[], None]) -> Callable[[], None]:
        """Call `changed`, in the thread, whenever there is something new here; what is returned ends that."""
        return self._listeners.add(changed)

    def close(self) -> None:
        """Give up, and end the thread."""
        self._newest.close()

    def _done(self, wish: Wanted, result: Tracked | None) -> None:
        if result is not None:
            self.result, self.result_of = result, wish
            self._finished(wish)

    def _failed(self, wish: Wanted, error: Exception) -> None:
        if wish == self.asked:
            self.error = one_line(error) or type(error).__name__
        self._finished(wish)

    def _finished(self, wish: Wanted) -> None:
        if wish == self.asked:
            self.progress = None
        self._listeners.notify()

    def _run(self, wish: Wanted) -> Tracked | None:
        """Return what came of a mission; None: given up."""

        def report(progress: Progress) -> bool:
            if wish == self.asked:
                self.progress = progress
                self._listeners.notify()
            return not self._newest.overtaken

        return self._process(report, wish)


class MissionRuns:
    """Tracks one mission after the other, and keeps what the chain found in the last."""

    def __init__(self, folders: Sequence[Path]) -> None:
        """folders: that files may be read from."""
        self._folders = folders
        self._kept: _Detections | None = None

    def __call__(self, report: Callable[[Progress], bool], wish: Wanted) -> Tracked | None:
        """Return what came of a mission; None: given up. Raises RerunError, OdsError."""
        detections = self._detections(wish)
        tracking, collecting = Tracking(wish.settings), Collecting()
        reported_s = 0.0
        for found in detections:
            collecting.add(found, tracking.list_of(found))
            if (now_s := time.monotonic()) - reported_s >= PROGRESS_S:
                reported_s, done = now_s, len(collecting)
                if not report(Progress(done, len(detections), done == len(detections.found))):
                    return None
        data = detections.data
        counters = detections.counters + tracking.counters
        beside = Beside(
            data.poses_in_time, dict(data.truths), Mounting(wish.settings.mounting), map_after(tracking.tracker)
        )
        return collecting.result(beside, counters)

    def _detections(self, wish: Wanted) -> "_Detections":
        """Return the detections of a wish: those that are kept, as long as data and pipeline are the same."""
        kept = self._kept
        source, chain = wish[:2], part_of(wish.settings, PipelineConfig)
        if kept is None or kept.source != source:
            data = open_data(wish.reference, wish.scene, self._folders)
            kept = self._kept = _Detections(source, data, wish.settings)
        elif kept.chain != chain:
            kept = self._kept = _Detections(source, kept.data, wish.settings)
        return kept


class _Detections:
    """What the chain found, kept: for repeated use. The chain runs only for pings not yet processed."""

    def __init__(self, source: Any, data: Data, settings: MissionSettings) -> None:
        """Raises RerunError, OdsError."""
        if not data.timed:
            raise RerunError("images without times cannot be tracked")
        if not data.poses:
            raise RerunError("data without poses cannot be tracked")
        self.source, self.data, self.chain = source, data, part_of(settings, PipelineConfig)
        self.found: list[Found] = []
        detecting = Detecting(settings)
        self.counters: Counter[str] = detecting.counters
        self._coming: Iterator[tuple[Ping, Found]] = detecting.found(data.pings, data.poses_in_time)

    def __len__(self) -> int:
        return len(self.data.pings)

    def __iter__(self) -> Iterator[Found]:
        yield from self.found
        for _, found in self._coming:
            self.found.append(found)
            yield found


def map_after(tracker: MissionTracker | None) -> list[MapObject]:
    """Return the objects that a map would have after the mission: those hibernated, and the static ones in view."""
    if tracker is None or tracker.tracker.t_ns is None:
        return []
    asleep = {item.id: item for item in tracker.tracker.whole_map()}
    return [*(asleep | {item.id: item for item in tracker.resting(tracker.tracker.t_ns)}).values()]
