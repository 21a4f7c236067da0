"""Newest wins: of requests that come faster than they are done, all but the latest are dropped."""

import logging
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

AskT = TypeVar("AskT")
AnswerT = TypeVar("AnswerT")
log = logging.getLogger(__name__)
IDLE_S = 30.0
"""Without a request, after which what was kept for the next one is given back."""


class Newest(Generic[AskT, AnswerT]):
    """A thread that processes one request at a time, always the latest.

    `deliver` and `fail` are called in that thread; `fail` with whatever `work` raised.
    """

    def __init__(
        self, work: Callable[[AskT], AnswerT], deliver: Callable[[AskT, AnswerT], None],
        fail: Callable[[AskT, Exception], None], idle: Callable[[], object] = lambda: None, idle_s: float = IDLE_S,
    ) -> None:  # fmt: skip
        """idle: called in that thread, too, once nothing was asked for so long, and at its end: gives back memory."""
        self._work, self._deliver, self._fail, self._idle, self._idle_s = work, deliver, fail, idle, idle_s
        self._waiting: list[AskT] = []
        """One at most."""
        self._changed = threading.Condition()
        self._ends = False
        self.dropped = 0
        """Requests that a later one overtook."""
        self._thread = threading.Thread(target=self._run, daemon=True, name=getattr(work, "__name__", "newest"))
        self._thread.start()

    def ask(self, request: AskT) -> None:
        """Ask for something, instead of what still waits."""
        with self._changed:
            self.dropped += len(self._waiting)
            self._waiting[:] = [request]
            self._changed.notify()

    @property
    def overtaken(self) -> bool:
        """Return whether a later request waits, so that long work may stop."""
        return bool(self._waiting) or self._ends

    def rests(self, seconds: float) -> bool:
        """Let work that is not urgent wait for this time, s; return whether no later request came."""
        with self._changed:
            return not self._changed.wait_for(lambda: self.overtaken, seconds)

    def close(self) -> None:
        """End the thread, after what it does now."""
        with self._changed:
            self._ends = True
            self._waiting.clear()
            self._changed.notify()

    def _run(self) -> None:
        keeps = False
        while not self._ends:
            with self._changed:
                self._changed.wait_for(lambda: self.overtaken, self._idle_s if keeps else None)
                asked = [] if self._ends else [self._waiting.pop() for _ in self._waiting[:1]]
            for request in asked:
                self._do(request)
            if keeps and not asked:
                self._idle()
            keeps = bool(asked)
        if keeps:
            self._idle()

    def _do(self, request: AskT) -> None:
        try:
            answer = self._work(request)
        except Exception as error:  # whatever a stage of the user's own may raise
            log.debug("%s", error, exc_info=True)
            self._fail(request, error)
        else:
            self._deliver(request, answer)
