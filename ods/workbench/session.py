"""One browser's work: its history, and who is informed of each change."""

import itertools
import threading
from collections.abc import Callable
from pathlib import Path

from ods.workbench.engine.background.listeners import Listeners
from ods.workbench.engine.files.config_file import ConfigFile, load_config, refuse_new_plugins
from ods.workbench.model import actions as do
from ods.workbench.model.history import History
from ods.workbench.model.state import State, Tuning

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
        self._trusted = self.loaded
        self._history = History.of(state or State())
        self._listeners: Listeners[[State, State]] = Listeners()
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

    def load(self, file: Path) -> None:
        """Take another configuration for A, and as the one that saving is compared with. Raises OdsError, and changes
        nothing, for one that cannot be read, or names plug-ins that the first one does not."""
        loaded = load_config(file)
        refuse_new_plugins(loaded, self._trusted)
        self.do(do.SetTuning(Tuning(config=loaded.config), f"load {loaded.path.name}"))
        self.loaded = loaded

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
        return self._listeners.add(listener)

    def _change(self, change: Callable[[History], History]) -> None:
        with self._lock:
            before, self._history = self._history, change(self._history)
            if self._history is not before:
                self._listeners.notify(before.state, self.state)
