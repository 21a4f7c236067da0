"""Work that lasts, in a process of its own: the page's process goes on, and its memory does not grow with it."""

import contextlib
import multiprocessing
import os
import signal
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any, Concatenate, Generic, NamedTuple, ParamSpec, TypeVar

from ods.base.computer.resident import give_back_freed
from ods.base.errors import OdsError, one_line

Told = ParamSpec("Told")
WordT = TypeVar("WordT")
ResultT = TypeVar("ResultT")
GoesOn = Callable[[float], bool]
"""Gets the share that is done; returns whether the work is to go on."""
at_first: list[Callable[[], object]] = []
"""Done in each process before its work: what the page's process began with, such as plug-ins."""
NICER = 5
"""Than the page, when all computers are busy."""


class _Word(NamedTuple):
    """How far it is; answered by whether it goes on."""

    text: Any


class _Came(NamedTuple):
    result: Any


class _Failed(NamedTuple):
    why: str


def whole(_: object) -> bool:
    """Go on to the end."""
    return True


class OwnProcess(Generic[WordT, Told, ResultT]):
    """A process that is begun when something is asked for, and does one thing after the other until it is ended.

    What it keeps from one to the next costs the page's process nothing. For use by one thread.
    """

    def __init__(self, work: Callable[Concatenate[Callable[[WordT], bool], Told], ResultT], nicer: int = NICER) -> None:
        """work: copied there when it begins. nicer: how much less urgent than the page it is."""
        self._work, self._nicer = work, nicer
        self._running: tuple[BaseProcess, Connection] | None = None

    def __call__(self, tell: Callable[[WordT], bool], *args: Told.args, **kwargs: Told.kwargs) -> ResultT:
        """Return what the work makes of these, which are copied as the result is. Raises OdsError.

        tell: is called here with what the work says of how far it is; returns whether it is to go on.
        """
        said = self._asked(tell, args, kwargs)
        if isinstance(said, _Failed):
            raise OdsError(said.why)
        result: ResultT = said.result
        return result

    def end(self) -> None:
        """End it, and give back what it had; the next that is asked begins another."""
        if self._running is not None:
            (process, pipe), self._running = self._running, None
            pipe.close()
            process.join()
            give_back_freed()  # copies of what it took and returned

    def _asked(self, tell: Callable[[WordT], bool], args: Any, kwargs: Any) -> _Came | _Failed:
        said: Any = None
        try:
            pipe = self._begun()
            pipe.send((args, kwargs))
            while isinstance(said := pipe.recv(), _Word):
                pipe.send(tell(said.text))
        except (EOFError, OSError):
            said = _Failed("its process has ended before its time")
            self.end()
        except BaseException:  # of `tell`: the process still waits for its answer
            self.end()
            raise
        answer: _Came | _Failed = said
        return answer

    def _begun(self) -> Connection:
        if self._running is None:
            context = multiprocessing.get_context("spawn")  # of a process with threads no copy is safe
            here, there = context.Pipe()
            process = context.Process(target=_run, args=(there, self._work, self._nicer, at_first), daemon=True)
            process.start()
            there.close()
            self._running = process, here
        return self._running[1]


def in_own_process(
    work: Callable[Concatenate[Callable[[WordT], bool], Told], ResultT],
    tell: Callable[[WordT], bool],
    *args: Told.args,
    **kwargs: Told.kwargs,
) -> ResultT:
    """Return what `work(tell, ...)` returns in a process that is there for this only. Raises OdsError."""
    process = OwnProcess(work)
    try:
        return process(tell, *args, **kwargs)
    finally:
        process.end()


def _run(pipe: Connection, work: Callable[..., object], nicer: int, before: Sequence[Callable[[], object]]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the page's process ends this one
    os.nice(nicer)
    for each in before:
        each()

    def tell(word: object) -> bool:
        pipe.send(_Word(word))
        return bool(pipe.recv())

    with contextlib.suppress(EOFError, OSError):  # nobody asks, or waits, any more
        while True:
            args, kwargs = pipe.recv()
            said: _Came | _Failed
            try:
                said = _Came(work(tell, *args, **kwargs))
            except Exception as error:  # whatever a stage of the user's own may raise: the caller tells it
                said = _Failed(_why(error))
            pipe.send(said)


def _why(error: Exception) -> str:
    return one_line(error) if isinstance(error, OdsError) else f"{type(error).__name__}: {one_line(error)}"
