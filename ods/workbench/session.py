"""One browser's work: its history, and who wants to hear of each change."""

import itertools
import threading
from collections.abc import Callable
from pathlib import Path

from ods.workbench.engine.config_file import ConfigFile, load_config
from ods.workbench.model import actions as do
from ods.workbench.model.history import History
from ods.workbench.model.state import State

Listener = Callable[[State, State], None]
"""Called with the state before and the one after a change, in the thread that made it."""


class Session:
    """What is done in one browser; another has a session of its own. May be used from several threads."""

    _numbers = itertools.count(1)

    def __init__(
        self, state: State | None = None, folders: tuple[Path, ...] = (), loaded: ConfigFile | None = None
    ) -> None:
        """folders: that files may be read from and written to; loaded: the configuration that it began with, by default
        the one that comes with ODS."""
        self.number = next(self._numbers)
        self.folders = folders
        self.loaded = loaded or load_config()
        self._history = History.of(state or State())
        self._listeners: list[Listener] = []
        self._lock = threading.RLock()

    @property
    def state(self) -> State:
        """As it is now."""
        return self._history.state

    @property
    def history(self) -> History:
        """With all steps."""
        return self._history

    def do(self, action: do.Action) -> None:
        """Do an action. Raises PathError, and changes nothing, for what cannot be done."""
        self._change(lambda history: history.after(action))

    def undo(self) -> None:
        """Take the last step back."""
        self._change(History.undone)

    def redo(self) -> None:
        """Do again what was taken back last."""
        self._change(History.redone)

    def move_to(self, at: int) -> None:
        """Undo or redo up to a step of the history."""
        self._change(lambda history: history.moved_to(at))

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Call `listener` after each change; what is returned ends that."""
        self._listeners.append(listener)

        def stop() -> None:
            if listener in self._listeners:
                self._listeners.remove(listener)

        return stop

    def _change(self, change: Callable[[History], History]) -> None:
        with self._lock:
            before, self._history = self._history, change(self._history)
            if self._history is not before:
                for listener in list(self._listeners):
                    listener(before.state, self.state)
