"""Reads TOML files into typed settings; an unknown key or a bad value is one line that names file and key."""

import copy
import math
import os
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from ods.base.errors import OdsError, one_line
from ods.base.files.in_file import content_of
from ods.base.files.shipped import FOLDER
from ods.base.settings import Settings, complaint_of

MOST_DOTS = 200
"""Between two commas, brackets or equals signs: in a key each costs the parser as much as all before it."""
KINDS = {
    "site": "a configuration of the processes",
    "onboard": "one of the bench",
    "vehicle": "a scene",
    "beam_width_deg": "a simulated sonar",
    "apex_x_px": "the geometry of a fan",
}
"""What a file is that has a key of this name: each kind of file needs one of them, and none has two."""

SettingsT = TypeVar("SettingsT", bound=Settings)
AnyT = TypeVar("AnyT")


class ConfigError(OdsError):
    """The configuration is wrong; the text is one line: file, key, what is wrong with it."""


def load(path: Path, kind: type[SettingsT]) -> SettingsT:
    """Read a TOML file as `kind`. Relative paths inside are taken from the file's own folder.

    Raises ConfigError.
    """
    return _convert(path, _read(path), kind)


def load_table(path: Path, name: str, kind: type[SettingsT], whole: type[Settings] | None = None) -> SettingsT:
    """Read one table of a TOML file as `kind` and ignore the others. Raises ConfigError.

    whole: what the file is; no table may be there that it has not, and it has defaults for those that are not there.
    """
    data = _read(path)
    if whole is None:
        file = msgspec.defstruct("File", [(name, kind)])
    else:
        fields = msgspec.structs.fields(whole)
        others = [(field.name, Any, None) for field in fields if field.name != name]
        (wanted,) = [field for field in fields if field.name == name]
        own = (name, kind) if wanted.required else (name, kind, wanted.default)
        file = msgspec.defstruct("File", [own, *others], kw_only=True, forbid_unknown_fields=True)
    table: SettingsT = getattr(_convert(path, data, file), name)
    return table


def load_variants(path: Path, kind: type[SettingsT]) -> dict[str, SettingsT]:
    """Read a TOML file and its variants: by each one's name the file with what its table `[[variant]]` sets instead.

    Without variants it is the file itself, its name "". Raises ConfigError.
    """
    data = _read(path)
    tables = data.pop("variant", [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise ConfigError(f"{path}: variant: expected tables, [[variant]]")
    base = _convert(path, data, kind)
    varied: dict[str, SettingsT] = {}
    for place, table in enumerate(tables):
        name = table.pop("name", None)
        if not isinstance(name, str) or not name or name in varied:
            raise ConfigError(f"{path}: variant[{place}].name: must differ from the other variants' names")
        try:
            varied[name] = _convert(path, _merged(data, table), kind)
        except ConfigError as error:
            raise ConfigError(f"{path}: variant[{place}] ({name}): {str(error).removeprefix(f'{path}: ')}") from error
    return varied or {"": base}


def _merged(data: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    """Return tables with some keys set to others; tables in both are merged, all else is replaced."""
    both = dict(data)
    for key, value in over.items():
        old = both.get(key)
        both[key] = _merged(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
    return both


def _read(path: Path) -> dict[str, Any]:
    try:
        data = parsed_toml(content_of(path))
    except OSError as error:
        example = FOLDER / path.name
        lacking = isinstance(error, FileNotFoundError) and example.exists()  # as where no checkout is
        advice = f": --config names yours; one to start from is {example}" if lacking else ""
        raise ConfigError(f"{path}: {error.strerror}{advice}") from error
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise ConfigError(f"{path}: line {line} is not text in UTF-8: save the file in that encoding") from error
    except (ValueError, RecursionError) as error:  # no TOML, a number of 5000 digits, brackets in brackets
        raise ConfigError(f"{path}: not valid TOML: {one_line(error)}") from error
    _refuse_non_finite(data, path, "")
    return data


def parsed_toml(content: bytes) -> dict[str, Any]:
    """Return what a file of settings holds. Raises ValueError, RecursionError."""
    if any(part.count(b".") > MOST_DOTS for part in re.split(rb"[=,\[\]{}\n]", content)):
        raise ValueError(f"a key of more than {MOST_DOTS} parts")
    return tomllib.loads(content.decode("utf-8-sig").replace("\r\n", "\n"))


def _convert(path: Path, data: dict[str, Any], kind: type[AnyT]) -> AnyT:
    folder = path.resolve().parent

    def hook(wanted: type, value: Any) -> Any:
        if wanted is Path and isinstance(value, str):
            if not value:
                raise ValueError("must not be empty")
            return Path(os.path.normpath(folder / _expanded(value)))
        raise TypeError(f"Expected `str`, got `{type(value).__name__}`")

    try:
        return msgspec.convert(data, kind, dec_hook=hook)
    except msgspec.ValidationError as error:
        said = str(error)

        def is_refused(part: dict[str, Any]) -> bool:
            try:
                msgspec.convert(part, kind, dec_hook=hook)
            except msgspec.ValidationError as same:
                return str(same) == said
            return False

        complaint = _mistaken(data, kind) or _with_name(complaint_of(error, kind), data, is_refused)
        raise ConfigError(f"{path}: {complaint}") from error


def _mistaken(data: dict[str, Any], kind: type) -> str:
    """Return a text that a file is of another kind than the one wanted; "" where it is not."""
    names = {field.name for field in msgspec.structs.fields(kind)}
    wanted = [what for key, what in KINDS.items() if key in names]
    found = [what for key, what in KINDS.items() if key in data and key not in names]
    return f"is {found[0]}, not {wanted[0]}" if found and wanted and not names & KINDS.keys() & data.keys() else ""


def _with_name(complaint: str, data: dict[str, Any], is_refused: Callable[[dict[str, Any]], bool]) -> str:
    """Return a complaint of an entry of a table of any names, "a.b[...].c: is wrong", with the entry's name.

    msgspec does not name it: it is the one that is refused without the others.
    """
    key, entry, rest = complaint.partition("[...]")
    if not entry or ": " in key or "[" in key:
        return complaint
    steps = key.split(".")
    for name, value in _at(data, steps).items():
        alone = copy.deepcopy(data)
        _at(alone, steps[:-1])[steps[-1]] = {name: value}
        if is_refused(alone):
            return f"{key}.{name}{rest}"
    return complaint


def _at(data: dict[str, Any], steps: list[str]) -> dict[str, Any]:
    for step in steps:
        data = data[step]
    return data


def _expanded(path: str) -> Path:
    """Return a path without `~`; an unknown home is Debian's for a user without one, and fails where it is used."""
    try:
        return Path(path).expanduser()
    except RuntimeError:
        return Path("/nonexistent", *Path(path).parts[1:])


def _refuse_non_finite(value: Any, path: Path, key: str) -> None:
    if isinstance(value, dict):
        for name, item in value.items():
            _refuse_non_finite(item, path, f"{key}.{name}" if key else name)
    elif isinstance(value, list):
        for index, item in enumerate(value):
            _refuse_non_finite(item, path, f"{key}[{index}]")
    elif isinstance(value, float) and not math.isfinite(value):
        raise ConfigError(f"{path}: {key}: must be a finite number, got {value}")
