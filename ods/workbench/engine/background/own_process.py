"""Work that lasts, in a process of its own: the page's process goes on, and its memory does not grow with it."""

import contextlib
import multiprocessing
import os
import signal
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from typing import Any, Concatenate, NamedTuple, ParamSpec, TypeVar

from ods.base.errors import OdsError, one_line

Told = ParamSpec("Told")
ResultT = TypeVar("ResultT")
GoesOn = Callable[[float], bool]
"""Gets the share that is done; returns whether the work is to go on."""
NICER = 5
"""Than the page, when all computers are busy."""


class _Share(NamedTuple):
    """How far it is; answered by whether it goes on."""

    done: float


class _Came(NamedTuple):
    result: Any


class _Failed(NamedTuple):
    why: str


def whole(_: float) -> bool:
    """Go on to the end."""
    return True


def in_own_process(
    work: Callable[Concatenate[GoesOn, Told], ResultT], tell: GoesOn, *args: Told.args, **kwargs: Told.kwargs
) -> ResultT:
    """Return what `work(tell, ...)` returns in a new process; what it takes and returns is copied. Raises OdsError.

    tell: is called here, in the thread of the caller.
    """
    context = multiprocessing.get_context("spawn")  # of a process with threads no copy is safe
    here, there = context.Pipe()
    process = context.Process(target=_run, args=(there, partial(work, **kwargs), args), daemon=True)
    process.start()
    there.close()
    try:
        while isinstance(said := here.recv(), _Share):
            here.send(tell(said.done))
    except (EOFError, OSError):
        said = _Failed("its process has ended before its time")
    finally:
        here.close()
        process.join()
    if isinstance(said, _Failed):
        raise OdsError(said.why)
    result: ResultT = said.result
    return result


def _run(pipe: Connection, work: Callable[..., object], args: tuple[object, ...]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the page's process ends this one
    os.nice(NICER)

    def tell(share: float) -> bool:
        pipe.send(_Share(share))
        return bool(pipe.recv())

    said: _Came | _Failed
    try:
        said = _Came(work(tell, *args))
    except Exception as error:  # whatever a stage of the user's own may raise: the caller tells it
        said = _Failed(one_line(error) if isinstance(error, OdsError) else f"{type(error).__name__}: {one_line(error)}")
    with contextlib.suppress(OSError):  # nobody waits any more
        pipe.send(said)
