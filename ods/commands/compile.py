"""`ods compile`: compiles all that the on-board processes will call, so that they start at once and without numba.

Where what the simulator needs is installed its kernels too, for workbench, `ods simulate` and bench: not on board.
"""

import hashlib
import os
import subprocess
import sys
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path

import msgspec

import ods
from ods.base import clock
from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.base.terminal import StatusLine
from ods.compiled import cache_folder, kernel, machine_code
from ods.config import OnboardConfig
from ods.runtime.ending import end_at_once, end_with

_PACKAGE = Path(ods.__file__).parent
_SIMULATES = find_spec("scipy") is not None
"""Of the extras `bench` and `workbench`."""
NOT_COMPILED = 1
"""Exit code of `--check` when a process would need numba."""
NAMED = 5
"""Kernels, of those that are not compiled."""
LEFT_S = 60.0
"""A temporary file so old is nobody's: writing one takes milliseconds."""


class CompileError(OdsError):
    """The kernels cannot be compiled or kept; the text is one line."""


def add_arguments(parser: ArgumentParser) -> None:
    """Whether to compile at all."""
    parser.add_argument("--check", action="store_true", help="only tell whether everything is compiled")


def run(args: Namespace) -> int:
    """Compile what is not compiled yet; with `--check` return NOT_COMPILED if there is anything. Raises OdsError."""
    settings = load(args.config, OnboardConfig)
    if args.check:
        return _check(settings)
    job, known = _job(settings), machine_code.load(_PACKAGE)
    if known is not None and job in known.jobs:
        print("all kernels are compiled")
        return 0
    folder = cache_folder.writable_folder(_PACKAGE)
    if folder is None:
        raise CompileError("no folder for compiled kernels is safe and writable: set ODS_CACHE_DIR")
    print(f"compiling the kernels of {args.config}: some minutes", flush=True)
    end_at_once()
    _clear(folder)
    begun = time.monotonic()
    _compile(settings, args.config)
    _keep(folder, job, known, args.config, may_need_numba=bool(_plugins(settings)))
    count = sum(len(dispatcher.overloads) for dispatcher in kernel.DISPATCHERS.values())
    print(f"compiled {count} variants of kernels in {time.monotonic() - begun:.0f} s, kept in {folder}")
    return 0


def _clear(folder: Path) -> None:
    """Remove files that a process which was ended or killed had begun to write."""
    for file in (*folder.rglob("*.tmp.*"), *folder.glob(f"{machine_code.FILE}.*")):
        with suppress(OSError):
            if clock.utc_ns() / clock.NS - file.stat().st_mtime > LEFT_S:
                file.unlink()


def _job(settings: OnboardConfig) -> str:
    """Return a digest of what decides which kernels are called, and with which types."""
    tracker = settings.tracker
    named = settings.pipeline, tracker.plugins, tracker.observer, tracker.association
    digest = hashlib.sha256(msgspec.json.encode(named, enc_hook=str))
    digest.update(bytes([_SIMULATES]))
    for file in (*_PACKAGE.glob("*/warm_up.py"), *filter(Path.is_file, _plugins(settings))):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _plugins(settings: OnboardConfig) -> tuple[Path, ...]:
    return settings.pipeline.plugins + settings.tracker.plugins


def _compile(settings: OnboardConfig, config: Path) -> None:
    """Let all meet what it may meet, and show which kernel is compiled."""
    status = StatusLine()
    kernel.tell_compiling(lambda count, name: status.show(f"{count}: {name}"))
    with _another_process(config):
        _warm_up_pipeline(settings)
    _warm_up_others(settings)
    status.clear()


@contextmanager
def _another_process(config: Path) -> Iterator[None]:
    """Let a second processor, where there is one, compile what the pipeline does not call, for this process to load.

    They never write the same file of numba's cache, as they have no kernel in common. Should the other process fail,
    this one compiles the rest, or tells why it cannot.
    """
    if len(os.sched_getaffinity(0)) < 2:
        yield
        return
    code = f"from {__name__} import compile_others; compile_others({str(config)!r}, {os.getpid()})"
    with subprocess.Popen([sys.executable, "-P", "-c", code], stderr=subprocess.DEVNULL) as other:
        try:
            yield
        except BaseException:
            other.terminate()
            raise


def compile_others(config: str, parent: int) -> None:
    """Do a part of `ods compile`, in a process of its own."""
    end_at_once()
    if not end_with(parent):
        return
    _warm_up_others(load(Path(config), OnboardConfig))


def warm_up(settings: OnboardConfig) -> None:
    """Let the pipeline and the tracker of these settings, and a simulator, process all that they may meet."""
    _warm_up_pipeline(settings)
    _warm_up_others(settings)


def _warm_up_pipeline(settings: OnboardConfig) -> None:
    from ods.pipeline import warm_up as pipeline

    pipeline.warm_up(settings.pipeline)
    pipeline.warm_up(settings.pipeline, watch=lambda _image: None)  # the workbench watches


def _warm_up_others(settings: OnboardConfig) -> None:
    from ods.tracker import warm_up as tracker

    tracker.warm_up(settings.tracker)
    if _SIMULATES:
        from ods.sim_sonar import warm_up as simulator

        simulator.warm_up()


def _keep(
    folder: Path, job: str, known: machine_code.MachineCode | None, config: Path, *, may_need_numba: bool
) -> None:
    """Write the machine code and try it in a process of its own; what fails there is not left.

    may_need_numba: for kernels of plug-ins, of which no machine code is kept.
    """
    from ods.compiled.object_code import keep

    try:
        file = keep(folder, job, known)
    except OSError as error:
        raise CompileError(f"{folder}: {error.strerror}") from error
    tried = subprocess.run(
        [sys.executable, "-P", "-m", "ods", "compile", "--check", "--config", str(config)],
        capture_output=True,
        text=True,
        check=False,
    )
    if tried.returncode and not (tried.returncode == NOT_COMPILED and may_need_numba):
        file.unlink(missing_ok=True)  # another `ods compile` may have cleared it away: its sources had changed
        said = (tried.stdout + tried.stderr).strip().splitlines() or [f"exit code {tried.returncode}"]
        raise CompileError(f"the machine code does not work, so processes go on using numba's cache: {said[-1]}")


def not_compiled(names: Sequence[str]) -> str:
    """Return the line that names kernels for which numba was needed, not all of hundreds; none: something else did."""
    if not names:
        return "not compiled: numba was imported"
    others = len(names) - NAMED
    return f"not compiled: {', '.join(names[:NAMED])}" + (f" and {others} more" if others > 0 else "")


def _check(settings: OnboardConfig) -> int:
    kernel.do_without_numba()
    begun = time.monotonic()
    warm_up(settings)
    if "numba" in sys.modules:
        print(not_compiled(list(kernel.DISPATCHERS)))
        return NOT_COMPILED
    print(f"all kernels are compiled; they warm up in {time.monotonic() - begun:.1f} s")
    return 0
