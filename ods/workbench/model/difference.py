"""In what two configurations differ, setting by setting; and a configuration's file with just that changed in it."""

from collections.abc import Callable
from typing import Any, NamedTuple

import tomlkit
from tomlkit.exceptions import TOMLKitError

from ods.base.settings import Settings
from ods.workbench.model.paths import tables_of
from ods.workbench.model.short_tables import short_tables

Keys = tuple[str | int, ...]
MOVED = {"mounting": ("sonar", "mounting")}
"""What pipeline and tracker read under a name of its own stands elsewhere in the file."""


class Difference(NamedTuple):
    """One setting that differs."""

    keys: Keys
    """("tracker", "echo", "loss_rate"), ("pipeline", "stage", 2, "high")."""
    before: Any
    """None: not reported."""
    after: Any
    """None: as by default."""

    @property
    def path(self) -> str:
        """As messages write it."""
        return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in self.keys).lstrip(".")


def differences(before: Settings, after: Settings) -> list[Difference]:
    """Return in which settings two of a kind differ; what is as by default is None."""
    return _differences((), short_tables(before), short_tables(after))


def _differences(keys: Keys, before: Any, after: Any) -> list[Difference]:
    if before == after:
        return []
    if isinstance(before, dict) and isinstance(after, dict):
        names = [*before, *(name for name in after if name not in before)]
        pairs: list[tuple[str | int, Any, Any]] = [(name, before.get(name), after.get(name)) for name in names]
        return [each for name, old, new in pairs for each in _differences((*keys, name), old, new)]
    if _alike(before, after):
        pairs = [(place, old, new) for place, (old, new) in enumerate(zip(before, after, strict=True))]
        return [each for place, old, new in pairs for each in _differences((*keys, place), old, new)]
    return [Difference(keys, before, after)]


def _alike(before: Any, after: Any) -> bool:
    """Return whether both are lists of the same tables, by `use`, so that each can be compared with its own."""
    if not (isinstance(before, list) and isinstance(after, list) and len(before) == len(after)):
        return False
    return all(
        isinstance(old, dict) and isinstance(new, dict) and old.get("use") == new.get("use")
        for old, new in zip(before, after, strict=True)
    )


def changed_text(text: str, changes: list[Difference]) -> str:
    """Return a configuration's TOML text with these settings changed; all else of it, comments too, stays.

    Raises ValueError where the text is no TOML.
    """
    try:
        document = tomlkit.parse(text)
    except TOMLKitError as error:
        raise ValueError(f"not valid TOML: {error}") from error
    for change in changes:
        keys = (*MOVED.get(str(change.keys[0]), change.keys[:1]), *change.keys[1:])
        _change(document, keys, change.after)
    return tomlkit.dumps(document)


def with_texts(text: str, other: Callable[[str], str]) -> str:
    """Return a TOML text, which is valid, with some of its texts changed. other: gets one, returns what it becomes."""
    document = tomlkit.parse(text)

    def change(table: Any) -> None:
        for key, value in table.items() if isinstance(table, dict) else enumerate(table):
            if isinstance(value, dict | list):
                change(value)
            elif isinstance(value, str) and (changed := other(value)) != value:
                table[key] = changed

    change(document)
    return tomlkit.dumps(document)


def _change(table: Any, keys: Keys, value: Any) -> None:
    for key in keys[:-1]:
        if not isinstance(key, int) and key not in table:
            table[key] = tomlkit.table()
        table = table[key]
    if value is not None:
        table[keys[-1]] = _item(value)
    elif keys[-1] in table:
        del table[keys[-1]]


def _item(value: Any) -> Any:
    """Return a value as it is best read in a file: lists of tables as [[...]]."""
    if isinstance(value, list) and value and all(isinstance(item, dict) for item in value):
        tables = tomlkit.aot()
        for item in value:
            tables.append(tomlkit.item(item))
        return tables
    return tables_of(value) if isinstance(value, Settings) else value
