"""Plug-ins: parts of the user's own, which register themselves by name when their file or module is imported.

Each table of the configuration that takes some has the key `plugins` and a `PluginGroup`. An installed package names
its module in an entry point of the group instead. A part's register is a dict by name; `add` refuses one that is taken.
"""

import importlib
import importlib.metadata
import importlib.util
import os
import sys
from collections.abc import Iterable
from functools import cache
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from ods.base.errors import OdsError, one_line
from ods.base.files.ownership import weakness

PartT = TypeVar("PartT")

LEAST_LOGIN_UID = 1000
"""User ids below are those of root and of services."""


class PluginError(OdsError, ValueError):
    """A plug-in cannot be used; the text is one line that names the key, the file and what is wrong."""


class PluginGroup(NamedTuple):
    """Where the plug-ins of one table are named."""

    key: str
    """In the configuration, such as "pipeline.plugins"."""
    entry_points: str
    """Entry points of installed packages of this group name modules."""

    def may_add(self, named: Iterable[Path]) -> bool:
        """Return whether there is any plug-in, which may know more names than those that come with ODS."""
        return any(True for _ in named) or bool(installed(self.entry_points))

    def load(self, named: Iterable[Path]) -> None:
        """Import the modules of the entry points and what the key names, once a process each. Raises PluginError.

        named: Python files, `.py`; anything else is a module by its dotted name, whatever folder stands before it.
        """
        for entry in installed(self.entry_points):
            try:
                entry.load()
            except (Exception, SystemExit) as error:
                raise PluginError(f"entry point {self.entry_points} {entry.name}: {reason(error)}") from error
        for index, place in enumerate(named):
            is_file = place.suffix == ".py"
            try:
                _run_file(place.resolve()) if is_file else _import(place.name)
            except (Exception, SystemExit) as error:
                what = place if is_file else place.name
                raise PluginError(f"{self.key}[{index}] ({what}): {reason(error)}") from error


@cache
def installed(group: str) -> importlib.metadata.EntryPoints:
    """Return the entry points of a group; to find them all packages are read."""
    return importlib.metadata.entry_points(group=group)


def add(register: dict[str, PartT], kind: str, name: str, part: PartT) -> None:
    """Put a part into its register. Raises PluginError when the name is another one's."""
    known = register.get(name)
    if known is not None and known != part:
        raise PluginError(f"{kind} {name}: the name is already taken by {_origin(known)}")
    register[name] = part


def reason(error: BaseException) -> str:
    """Return the reason of a failure in a plug-in, as one line."""
    text = one_line(error)
    return text if isinstance(error, OdsError) else f"{type(error).__name__}: {text}"


def _origin(part: Any) -> str:
    """Return the full name of the function or class that a part is, or that it names as `made_by`."""
    made_by = getattr(part, "made_by", part)
    return f"{made_by.__module__}.{made_by.__qualname__}"


def _import(module: str) -> None:
    if module not in sys.modules:
        found = PathFinder.find_spec(module.partition(".")[0])
        if found is not None and found.origin is not None:
            _refuse_unsafe(Path(found.origin))
        importlib.import_module(module)


def _run_file(file: Path) -> None:
    """Import a file as a module of its own, once a process."""
    name = f"ods_plugin:{file}"
    if name in sys.modules:
        return
    _refuse_unsafe(file)
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise ImportError("not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # before it runs: dataclasses and typing look their module up
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise


def _refuse_unsafe(file: Path) -> None:
    """Raise PluginError if another user could make root or a service run code through that file."""
    if file.exists() and _has_rights_of_its_own() and (why := weakness(file)):
        raise PluginError(
            f"{why}; not loaded as root or by a service, as whoever can write to it would gain those rights"
        )


def _has_rights_of_its_own() -> bool:
    """Return whether this process runs as root or as a service, of systemd or of an `ods run` that is one."""
    started_by_systemd = os.environ.get("SYSTEMD_EXEC_PID") in (str(os.getpid()), str(os.getppid()))
    return os.geteuid() < LEAST_LOGIN_UID or started_by_systemd
