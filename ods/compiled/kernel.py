"""The one way the on-board code compiles: numba, cached on disk, NaN and infinity kept as IEEE 754 has them.

An on-board process has no use for a compiler: it takes the machine code that `ods compile` left (machine_code.py).
"""

import logging
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

from ods.compiled import cache_folder
from ods.compiled.machine_code import LinkedCode, load

log = logging.getLogger(__name__)

F = TypeVar("F", bound=Callable[..., Any])

_FASTMATH = {"reassoc", "contract", "arcp", "nsz"}
"""Sums may be reordered, so that they vectorise. Not `nnan`, not `ninf`: bad samples must compare as false."""
DISPATCHERS: dict[str, Any] = {}
"""Every kernel that numba compiles in this process, by module and name."""

Tell = Callable[[int, str], None]

_without_numba = False
_tell: Tell | None = None


def kernel(function: F) -> F:
    """Compile `function` at its first call for the array types it is given; later runs load it from the cache."""
    return compiled(function, fastmath=_FASTMATH)


def inlined(function: F) -> F:
    """As `kernel`, compiled into each kernel that calls it: for small ones of many numbers, which a call would copy."""
    return compiled(function, fastmath=_FASTMATH, forceinline=True)


def compiled(function: F, **options: Any) -> F:
    """Compile `function` by numba with these options, division by zero giving infinity, and cache it."""
    linked = _linked(cache_folder.package_of(_source_of(function))) if _without_numba else None
    if linked is None:
        return cast(F, _by_numba(function, options))
    return cast(F, linked.kernel(function, lambda: _by_numba(function, options)))


def do_without_numba() -> None:
    """Let all kernels defined from now on be machine code, where `ods compile` left it; numba is imported where not."""
    global _without_numba
    _without_numba = True


def tell_compiling(tell: Tell) -> None:
    """Call `tell` with number and name of each kernel that numba is about to compile, from now on."""
    global _tell
    _tell = tell


@cache
def _listen() -> None:
    """Hear what numba compiles."""
    from numba.core import event

    class Listener(event.Listener):
        count = 0

        def on_start(self, begun: event.Event) -> None:
            self.count += 1
            if _tell:
                _tell(self.count, begun.data["dispatcher"].py_func.__qualname__)

        def on_end(self, _ended: event.Event) -> None:
            pass

    register: Callable[[str, event.Listener], None] = event.register
    register("numba:compile", Listener())


@cache
def _linked(package: Path) -> LinkedCode | None:
    code = load(package)
    if code is None:
        log.warning("no machine code of this version for this processor: kernels are compiled; see `ods compile`")
    return LinkedCode(code) if code else None


def _by_numba(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    from numba import config, njit

    _listen()
    folder = cache_folder.writable_folder(cache_folder.package_of(_source_of(function)))
    if folder is None:
        _say_that_nothing_is_kept()
    config.CACHE_DIR = str(folder or "")  # type: ignore[attr-defined]
    dispatcher = njit(cache=folder is not None, error_model="numpy", **options)(function)
    DISPATCHERS[name_of(function)] = dispatcher
    return dispatcher


@cache
def _say_that_nothing_is_kept() -> None:
    log.warning("kernels are compiled at each start: no folder for them is safe and writable; set ODS_CACHE_DIR")


def name_of(function: Callable[..., Any]) -> str:
    """Return the name under which a kernel's machine code is kept."""
    return f"{function.__module__}.{function.__qualname__}"


def _source_of(function: Callable[..., Any]) -> Path:
    return Path(function.__code__.co_filename)
