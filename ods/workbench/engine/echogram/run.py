"""The echogram of what a state shows, read in a process of its own: the newest wish only, and shown as it grows."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from ods.base.errors import OdsError, one_line
from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.engine.background.listeners import Listeners
from ods.workbench.engine.background.newest import Newest
from ods.workbench.engine.background.own_process import OwnProcess, in_own_process, whole
from ods.workbench.engine.data import open_data
from ods.workbench.engine.echogram.levels import Echogram, read_echogram
from ods.workbench.model.state import DataReference, State


class Wanted(NamedTuple):
    """Of which pings, and what of them."""

    reference: DataReference
    scene: SceneFile | None
    """None where the data do not come from a scene."""
    beam: int | None


def wanted(state: State) -> Wanted:
    """Return what a state asks for; two that are equal give the same echogram."""
    scene = state.scene if state.data.kind == "scene" else None
    return Wanted(state.data, scene, state.view.echogram_beam)


def read(report: Callable[[Echogram], bool], wish: Wanted, folders: Sequence[Path]) -> Echogram | None:
    """Return an echogram; None: given up. Raises OdsError. folders: that files may be read from."""
    return read_echogram(open_data(wish.reference, wish.scene, folders), wish.beam, report)


class EchogramRun:
    """Reads echograms in a process of its own. What came of it stays here."""

    def __init__(self, folders: Sequence[Path]) -> None:
        """folders: that files may be read from."""
        self.result: Echogram | None = None
        """The newest echogram, complete or as far as it is read."""
        self.result_of: Wanted | None = None
        """The request that `result` belongs to."""
        self.asked: Wanted | None = None
        self.error = ""
        """Why nothing came of what was asked for last; one line."""
        self._done: Wanted | None = None
        """Of what `result` was last read to the end."""
        self._folders = tuple(folders)
        self._listeners: Listeners[[]] = Listeners()
        self._process = OwnProcess(read)
        self._newest: Newest[Wanted, Echogram | None] = Newest(self._read, self._take, self._failed, self._process.end)

    @property
    def is_whole(self) -> bool:
        """Whether all of what was asked for last is there."""
        return self.asked is not None and self._done == self.asked

    def ask(self, wish: Wanted) -> None:
        """Read this, unless it was asked for last."""
        if wish != self.asked:
            self.asked, self.error = wish, ""
            self._newest.ask(wish)
            self._listeners.notify()

    def whole(self, state: State) -> Echogram:
        """Return all of a state's echogram: what is there, or read now, which lasts. Raises OdsError."""
        wish = wanted(state)
        if self.result is not None and self.result_of == self._done == wish:
            return self.result
        made = in_own_process(read, whole, wish, self._folders)
        if made is None:
            raise OdsError("echogram: cancelled")
        return made

    def listen(self, changed: Callable[[], None]) -> Callable[[], None]:
        """Call `changed`, in the thread, whenever there is something new here; what is returned ends that."""
        return self._listeners.add(changed)

    def close(self) -> None:
        """Give up, and end the thread."""
        self._newest.close()

    def _read(self, wish: Wanted) -> Echogram | None:
        def report(part: Echogram) -> bool:
            self._show(wish, part)
            return not self._newest.overtaken

        return self._process(report, wish, self._folders)

    def _show(self, wish: Wanted, part: Echogram) -> None:
        self.result, self.result_of = part, wish
        self._listeners.notify()

    def _take(self, wish: Wanted, made: Echogram | None) -> None:
        if made is not None:
            self._done = wish
            self._show(wish, made)

    def _failed(self, wish: Wanted, error: Exception) -> None:
        if wish == self.asked:
            self.error = one_line(error) or type(error).__name__
        self._listeners.notify()
