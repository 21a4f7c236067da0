"""Work that lasts, in a process of its own: the page's process goes on, and its memory does not grow with it."""

import contextlib
import multiprocessing
import os
import signal
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any, Concatenate, Generic, NamedTuple, ParamSpec, TypeVar

from ods.base.computer.resident import release_freed_memory
from ods.base.errors import OdsError, one_line

Params = ParamSpec("Params")
ProgressT = TypeVar("ProgressT")
ResultT = TypeVar("ResultT")
GoesOn = Callable[[float], bool]
"""Gets the share that is done; returns whether the work is to go on."""
at_first: list[Callable[[], object]] = []
"""Done in each process before its work: what the page's process began with, such as plug-ins."""
NICER = 5
"""Than the page, when all computers are busy."""
SILENT_S = 600.0
"""Work that neither ends nor reports progress for so long hangs: its process is killed."""
ENDING_S = 5.0
"""A process has this long to end by itself once nobody waits for it."""


class _Progress(NamedTuple):
    """How far it is; answered by whether it goes on."""

    progress: Any


class _Done(NamedTuple):
    result: Any


class _Failed(NamedTuple):
    why: str


def whole(_: object) -> bool:
    """Go on to the end."""
    return True


class OwnProcess(Generic[ProgressT, Params, ResultT]):
    """A process that is begun when something is asked for, and does one thing after the other until it is ended.

    What it keeps from one to the next costs the page's process nothing. For use by one thread.
    """

    def __init__(
        self, work: Callable[Concatenate[Callable[[ProgressT], bool], Params], ResultT], nicer: int = NICER
    ) -> None:
        """work: copied there when it begins. nicer: how much less urgent than the page it is."""
        self._work, self._nicer = work, nicer
        self._running: tuple[BaseProcess, Connection] | None = None

    def __call__(
        self, on_progress: Callable[[ProgressT], bool], *args: Params.args, **kwargs: Params.kwargs
    ) -> ResultT:
        """Return what the work makes of these, which are copied as the result is.

        on_progress: is called here with what the work reports of its progress; returns whether it is to go on.
        Raises OdsError for what the work raises, and where its process dies or hangs.
        """
        answer = self._asked(on_progress, args, kwargs)
        if isinstance(answer, _Failed):
            raise OdsError(answer.why)
        result: ResultT = answer.result
        return result

    def end(self) -> None:
        """End it, and give back what it had; the next that is asked begins another."""
        if self._running is not None:
            (process, pipe), self._running = self._running, None
            pipe.close()
            process.join(ENDING_S)
            process.kill()  # does nothing to one that has ended
            process.join()
            release_freed_memory()  # copies of what it took and returned

    def _asked(self, on_progress: Callable[[ProgressT], bool], args: Any, kwargs: Any) -> _Done | _Failed:
        try:
            pipe = self._begun()
            pipe.send((args, kwargs))
            while pipe.poll(SILENT_S):
                answer = pipe.recv()
                if isinstance(answer, _Done | _Failed):
                    return answer
                pipe.send(on_progress(answer.progress))
            why = f"hangs: no progress in {SILENT_S:.0f} s; its process was killed"
        except (EOFError, OSError):
            why = "its process ended unexpectedly"
        except BaseException:  # of `on_progress`: the process still waits for its answer
            self.end()
            raise
        self.end()
        return _Failed(why)

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
    work: Callable[Concatenate[Callable[[ProgressT], bool], Params], ResultT],
    on_progress: Callable[[ProgressT], bool],
    *args: Params.args,
    **kwargs: Params.kwargs,
) -> ResultT:
    """Return what `work(on_progress, ...)` returns in a process that is there for this only. Raises OdsError."""
    process = OwnProcess(work)
    try:
        return process(on_progress, *args, **kwargs)
    finally:
        process.end()


def _run(pipe: Connection, work: Callable[..., object], nicer: int, before: Sequence[Callable[[], object]]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the page's process ends this one
    os.nice(nicer)
    for each in before:
        each()

    def report(progress: object) -> bool:
        pipe.send(_Progress(progress))
        return bool(pipe.recv())

    with contextlib.suppress(EOFError, OSError):  # nobody asks, or waits, any more
        while True:
            args, kwargs = pipe.recv()
            answer: _Done | _Failed
            try:
                answer = _Done(work(report, *args, **kwargs))
            except Exception as error:  # whatever a stage of the user's own may raise: the caller reports it
                answer = _Failed(_why(error))
            pipe.send(answer)


def _why(error: Exception) -> str:
    return one_line(error) if isinstance(error, OdsError) else f"{type(error).__name__}: {one_line(error)}"
