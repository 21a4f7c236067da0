"""One value deep in typed settings, by its path as messages write it: "tracker.echo.loss_rate", "stage[2].high"."""

import re
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from ods.base.errors import OdsError
from ods.base.settings import Settings, complaint_of

SettingsT = TypeVar("SettingsT", bound=Settings)


class PathError(OdsError):
    """There is no such place, or the value does not go there; the text is one line that names the key."""


def value_at(settings: Settings, path: str) -> Any:
    """Return the value at a path, as TOML and JSON have it: dict, list, str, number, bool or None. Raises PathError."""
    place = tables_of(settings)
    for step in _steps(path):
        place = _inside(place, step, path)
    return place


def with_value(settings: SettingsT, path: str, value: Any) -> SettingsT:
    """Return settings with another value at a path; all are checked again. Raises PathError."""
    return with_tables(settings, path, lambda _: value)


def with_tables(settings: SettingsT, path: str, change: Any) -> SettingsT:
    """Return settings in which `change` has been called with the value at a path, and returned the new one."""
    tables = tables_of(settings)
    *before, last = _steps(path)
    place = tables
    for step in before:
        place = _inside(place, step, path)
    place[last] = change(_inside(place, last, path))
    return typed(tables, type(settings))


def tables_of(settings: Settings) -> Any:
    """Return settings as tables of their own, lists and plain values."""
    return _with_lists(msgspec.to_builtins(settings, enc_hook=str, builtin_types=()))


def _with_lists(value: Any) -> Any:
    """Return builtins with lists for tuples, so that a place in them can be changed."""
    if isinstance(value, dict):
        return {name: _with_lists(item) for name, item in value.items()}
    return [_with_lists(item) for item in value] if isinstance(value, list | tuple) else value


def typed(tables: Any, kind: type[SettingsT]) -> SettingsT:
    """Return tables as settings. Raises PathError."""
    try:
        return msgspec.convert(tables, kind, dec_hook=_as_path)
    except msgspec.ValidationError as error:
        raise PathError(complaint_of(error, kind)) from error


def _as_path(wanted: type, value: Any) -> Any:
    if wanted is Path and isinstance(value, str):
        return Path(value)
    raise TypeError(f"Expected `str`, got `{type(value).__name__}`")


def _steps(path: str) -> list[str | int]:
    if not re.fullmatch(r"\w+(\[\d+\])*(\.\w+(\[\d+\])*)*", path):
        raise PathError(f"{path or 'path'}: not the path of a setting")
    return [int(index) if index else name for name, index in re.findall(r"(\w+)|\[(\d+)\]", path.replace("[", ".["))
            if name or index]  # fmt: skip


def _inside(place: Any, step: str | int, path: str) -> Any:
    try:
        return place[step]
    except (KeyError, IndexError, TypeError) as error:
        raise PathError(f"{path}: no such setting") from error
