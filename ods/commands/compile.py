"""`ods compile`: compiles all that the on-board processes will call, so that they start at once and without numba.

Where the simulator can run, its kernels too, for the workbench and `ods track SCENE.toml`.
"""

import hashlib
import subprocess
import sys
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import msgspec

import ods
from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.base.terminal import StatusLine
from ods.compiled import cache_folder, kernel, machine_code
from ods.config import OnboardConfig

_PACKAGE = Path(ods.__file__).parent
_SIMULATOR_NEEDS = ("scipy",)
"""Of the optional dependencies."""
NOT_COMPILED = 1
"""Exit code of `--check` when a process would need numba."""


class CompileError(OdsError):
    """The kernels cannot be compiled or kept; the text is one line."""


def add_arguments(parser: ArgumentParser) -> None:
    """Whether to compile at all."""
    parser.add_argument("--check", action="store_true", help="only tell whether everything is compiled")


def run(args: Namespace) -> int:
    """Compile what is not compiled yet; with `--check` return NOT_COMPILED if there is anything. Raises OdsError."""
    settings = load(args.config, OnboardConfig)
    parts = tuple(_parts(settings, args.config))
    if args.check:
        return _check(parts)
    known = {part.name: machine_code.load(_PACKAGE, part.name) for part in parts}
    missing = [part for part in parts if (code := known[part.name]) is None or part.job not in code.jobs]
    if not missing:
        print("all kernels are compiled")
        return 0
    folder = cache_folder.writable_folder(_PACKAGE)
    if folder is None:
        raise CompileError("no folder for compiled kernels is safe and writable: set ODS_CACHE_DIR")
    for part in missing:
        print(f"compiling the kernels of {part.told}: a minute or so", flush=True)
        begun = time.monotonic()
        _compile(part)
        _keep(folder, part, known[part.name])
        count = sum(len(dispatcher.overloads) for dispatcher in kernel.DISPATCHERS[part.name].values())
        print(f"compiled {count} variants of kernels in {time.monotonic() - begun:.0f} s, kept in {folder}")
    _try_out(folder, missing, args.config, may_need_numba=bool(_plugins(settings)))
    return 0


class _Part(NamedTuple):
    """What is compiled, kept and linked together."""

    name: str
    told: str
    """What its kernels are of."""
    job: str
    """Digest of what decides which kernels are called, and with which types."""
    warm_up: Callable[[], None]


def _parts(settings: OnboardConfig, config: Path) -> Iterator[_Part]:
    yield _Part(kernel.ON_BOARD, str(config), _job(settings), partial(warm_up, settings))
    if all(map(find_spec, _SIMULATOR_NEEDS)):  # not on board
        from ods.sim_sonar import warm_up as simulator
        from ods.sim_sonar.kernel import PART

        job = hashlib.sha256(Path(simulator.__file__).read_bytes()).hexdigest()
        yield _Part(PART, "the simulator", job, simulator.warm_up)


def _job(settings: OnboardConfig) -> str:
    """Return a digest of what decides which kernels are called, and with which types."""
    tracker = settings.tracker
    named = settings.pipeline, tracker.plugins, tracker.observer, tracker.association
    digest = hashlib.sha256(msgspec.json.encode(named, enc_hook=str))
    shipped = (_PACKAGE / name / "warm_up.py" for name in ("pipeline", "tracker"))
    for file in (*shipped, *filter(Path.is_file, _plugins(settings))):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _plugins(settings: OnboardConfig) -> tuple[Path, ...]:
    return settings.pipeline.plugins + settings.tracker.plugins


def _compile(part: _Part) -> None:
    """Let a part meet all that it may meet, and show which kernel is compiled."""
    status = StatusLine()
    kernel.tell_compiling(lambda count, name: status.show(f"{count}: {name}"))
    part.warm_up()
    status.clear()


def warm_up(settings: OnboardConfig) -> None:
    """Let the pipeline and the tracker of these settings process all that they may meet."""
    from ods.pipeline import warm_up as pipeline
    from ods.tracker import warm_up as tracker

    pipeline.warm_up(settings.pipeline)
    pipeline.warm_up(settings.pipeline, watch=lambda _image: None)  # the workbench watches
    tracker.warm_up(settings.tracker)


def _keep(folder: Path, part: _Part, known: machine_code.MachineCode | None) -> None:
    """Write the machine code of a part."""
    from ods.compiled.object_code import keep

    try:
        keep(folder, part.name, part.job, known)
    except OSError as error:
        raise CompileError(f"{folder}: {error.strerror}") from error


def _try_out(folder: Path, parts: Sequence[_Part], config: Path, *, may_need_numba: bool) -> None:
    """Try machine code in a process of its own; what fails there is not left.

    may_need_numba: for kernels of plug-ins, of which no machine code is kept.
    """
    tried = subprocess.run(
        [sys.executable, "-P", "-m", "ods", "compile", "--check", "--config", str(config)],
        capture_output=True,
        text=True,
        check=False,
    )
    if tried.returncode and not (tried.returncode == NOT_COMPILED and may_need_numba):
        for part in parts:  # another `ods compile` may have cleared it away: its sources had changed
            (folder / machine_code.file_name(part.name)).unlink(missing_ok=True)
        said = (tried.stdout + tried.stderr).strip().splitlines() or [f"exit code {tried.returncode}"]
        raise CompileError(f"the machine code does not work, so processes go on using numba's cache: {said[-1]}")


def _check(parts: Sequence[_Part]) -> int:
    kernel.do_without_numba()
    begun = time.monotonic()
    for part in parts:
        part.warm_up()
    if "numba" in sys.modules:
        names = [name for part in parts for name in kernel.DISPATCHERS[part.name]]
        print(f"not compiled: {', '.join(names) or 'numba was imported'}")
        return NOT_COMPILED
    print(f"all kernels are compiled; they warm up in {time.monotonic() - begun:.1f} s")
    return 0
