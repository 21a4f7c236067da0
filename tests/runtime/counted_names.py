"""Finds the names of counters in the source tree: the text of whatever is, or may become, a key of a counter."""

import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

COUNTERS = {"counters", "losses"}
"""Names, attributes and parameters under which counters go, `_counters` and `own_counters` too."""
NAME = re.compile(r"[a-z]+(_[a-z]+)+")


@dataclass
class Counted:
    """What one module counts."""

    names: set[str] = field(default_factory=set)
    patterns: set[str] = field(default_factory=set)
    """Regular expressions: what the text of f-strings fixes."""
    texts: set[str] = field(default_factory=set)
    """Every text of the module, which may fill a pattern."""

    def matches(self, name: str) -> bool:
        """Tell whether `name` may be counted here."""
        filled = (re.fullmatch(pattern, name) for pattern in self.patterns)
        return name in self.names or any(match and match[1] in self.texts for match in filled)


def counted_in(source: str) -> Counted:
    """Return the names that a module counts.

    Keys of counters as written; members of an enumeration named `...Loss`; the only text of an exception raised, and
    texts given to a call beside a counter. Where a key is a variable, or a complaint is counted, every text that is
    given to a call or returned and looks like a name.
    """
    tree = ast.parse(source)
    found = Counted(texts=set(_texts(item for item in ast.walk(tree) if isinstance(item, ast.Constant))))
    variable = False
    for item in ast.walk(tree):
        if isinstance(item, ast.Subscript) and _is_counters(item.value):
            written, fixed = list(_texts([item.slice])), list(_fixed(item.slice))
            found.names.update(written)
            found.patterns.update(fixed)
            variable |= not written and not fixed
        elif isinstance(item, ast.ClassDef) and item.name.endswith("Loss"):
            found.names.update(_texts(line.value for line in item.body if isinstance(line, ast.Assign)))
        elif isinstance(item, ast.Raise) and isinstance(item.exc, ast.Call) and len(item.exc.args) == 1:
            found.names.update(filter(NAME.fullmatch, _texts(item.exc.args)))
        elif isinstance(item, ast.Call):
            variable |= _name_of(item.func).lstrip("_").startswith(("complain", "log_once"))
            found.names.update(_beside_counters(item))
    if variable:
        for item in ast.walk(tree):
            given = item.args if isinstance(item, ast.Call) else [item.value] if isinstance(item, ast.Return) else []
            found.names.update(filter(NAME.fullmatch, _texts(given)))
    return found


def all_counted(root: Path, without: Iterable[Path] = ()) -> dict[str, Counted]:
    """Return what each module below `root` counts."""
    files = [path for path in sorted(root.rglob("*.py")) if path not in set(without)]
    return {str(path.relative_to(root.parent)): counted_in(path.read_text(encoding="utf-8")) for path in files}


def _beside_counters(call: ast.Call) -> Iterator[str]:
    if any(_is_counters(argument) for argument in call.args):
        yield from filter(NAME.fullmatch, _texts(call.args))
    if _name_of(call.func) == "Counter":
        yield from (keyword.arg for keyword in call.keywords if keyword.arg)


def _texts(items: Iterable[ast.expr | None]) -> Iterator[str]:
    """Yield the texts that expressions may be, both ways of a condition."""
    for item in items:
        if isinstance(item, ast.IfExp):
            yield from _texts([item.body, item.orelse])
        elif isinstance(item, ast.Constant) and isinstance(item.value, str):
            yield item.value


def _fixed(key: ast.expr) -> Iterator[str]:
    if isinstance(key, ast.JoinedStr):
        parts = (re.escape(str(part.value)) if isinstance(part, ast.Constant) else "(.+)" for part in key.values)
        yield "".join(parts)


def _is_counters(item: ast.expr) -> bool:
    name = _name_of(item)
    return name.lstrip("_") in COUNTERS or name.endswith(tuple(f"_{name}" for name in COUNTERS))


def _name_of(item: ast.expr) -> str:
    return item.attr if isinstance(item, ast.Attribute) else item.id if isinstance(item, ast.Name) else ""
