"""Pages of the configuration."""

import inspect
from collections.abc import Collection, Iterable, Sequence
from typing import NamedTuple, get_args, get_origin, get_type_hints

import msgspec

from ods.base.field_docs import field_docs
from ods.base.settings import Settings
from ods.bench.settings import BenchConfig
from ods.config import OnboardConfig
from ods.reference.markdown import head, row, table as markdown_table
from ods.reference.type_names import choices, default_of, limits

SETTINGS = {
    "vehicle": "vehicle, bus and recordings", "sonar": "sonar", "nav": "navigation", "pipeline": "detection",
    "tracker": "tracker", "lists": "obstacle list, clearance and map", "bridges": "bridges", "bench": "bench",
}  # fmt: skip
"""Pages of settings, in their order."""
TABLES = {
    "sonar": "sonar", "nav": "nav", "pipeline": "pipeline", "tracker": "tracker", "tracker.planner": "lists",
    "tracker.bottom": "lists", "tracker.surface": "lists", "tracker.clearance": "lists", "tracker.map": "lists",
    "bridge": "bridges", "sim": "bench", "limits": "bench", "kill": "bench", "planner": "bench",
}  # fmt: skip
"""Page of each table and of those inside it; all others: "vehicle"."""
CONFIG_HEAD = """# Configuration

For installers. Generated from the settings types by `make docs`.

Files are TOML. An unknown key, a wrong type or a value out of range ends a command with one line that names file and
key,
and exit code 2. Relative paths start at the file's folder; `~` is the user's home.

A key's ending is its unit: `_m`, `_s`, `_deg`. The second column is the default, or a type if there is none; `required`
keys, numbers unless a type follows, must be set. `1..60` are limits, `(1..60)` is the usual range, as in the workbench:
other values are accepted, and `ods doctor` notes them.

"""


class Table(NamedTuple):
    """One TOML table: its path, the section about it, and the path of one described before that has the same keys."""

    path: str
    text: str
    same_as: str = ""


class Seen:
    """What the sections so far have described."""

    def __init__(self) -> None:
        self.kinds: dict[type, str] = {}
        """Path of the first table of each type, and of the first one with the keys of each of their bases."""
        self.whole = set[type]()
        """Types that have a table with all of their keys, and with no others."""
        self.sections: set[tuple[str, type]] = set()


def setting_pages() -> dict[str, str]:
    """Return the index of the tables, and a page for each group of them: name and text."""
    found: dict[str, list[Table]] = {page: [] for page in SETTINGS}
    seen = Seen()
    for config in (OnboardConfig, BenchConfig):
        for table in tables(config, "", seen):
            found[next((TABLES[each] for each in _parents(table.path) if each in TABLES), "vehicle")].append(table)
    rows = [row(f"[{_capital(SETTINGS[page])}]({page}.md)", _names(found[page])) for page in SETTINGS]
    rows += [
        row("[Equalizers and filters](stages.md), [detectors](detectors.md)", "`pipeline.stage[]`"),
        row("[Scene files](scene.md), [their images](image.md)", "config/scenes/*.toml"),
        row("[Sonar files](sonar-file.md)", "config/sonars/*.toml"),
    ]
    index = CONFIG_HEAD + markdown_table(("page", "tables"), rows)
    return {"configuration/README.md": index} | {
        f"configuration/{page}.md": head("Configuration", SETTINGS[page]) + sections(found[page]) for page in SETTINGS
    }


def _names(found: Iterable[Table]) -> str:
    return ", ".join(f"`{path}`" for path, *_ in found if "." not in path or path in TABLES)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def sections(found: Sequence[Table]) -> str:
    """Return the sections of a page; tables with the same keys share one."""
    here = {path for path, _, same_as in found if not same_as}
    text = ""
    for path, about, same_as in found:
        if same_as in here:
            continue
        if same_as:
            about = f"As `[{same_as}]`.\n"
        names = [path, *(table.path for table in found if table.same_as == path)]
        text += f"\n## {', '.join(f'[{name}]' for name in names)}\n\n{about}"
    return text


def _parents(path: str) -> list[str]:
    """Return a table's path and those of the tables that it is in, the longest first."""
    parts = path.replace("[]", "").split(".")
    return [".".join(parts[:n]) for n in range(len(parts), 0, -1)]


def tables(kind: type[msgspec.Struct], path: str, seen: Seen) -> list[Table]:
    """Return one TOML table and the tables inside it; what was described before is only named."""
    if (path, kind) in seen.sections:
        return []
    seen.sections.add((path, kind))
    if path and kind in seen.kinds:
        return [_described(kind, path, seen)]
    shared = {base: seen.kinds[base] for base in _bases(kind) if base in seen.kinds} if path else {}
    seen.kinds |= dict.fromkeys({kind, *_bases(kind)} - shared.keys(), path)
    seen.whole.add(kind)
    hints = get_type_hints(kind, include_extras=True)
    inner = list[Table]()
    for field in msgspec.structs.fields(kind):
        for item, suffix in _structs_inside(hints[field.name]):
            inner += tables(item, f"{path}.{field.name}".lstrip(".") + suffix, seen)
    known = {name: where for base, where in shared.items() for name in _unchanged(base, kind)}
    table = key_table(kind, known)
    shares = [
        _as_in(where, (name for name in known if known[name] == where)) for where in dict.fromkeys(known.values())
    ]
    return [Table(path, "\n".join([*shares, table or f"{_about(kind)}\n"])), *inner] if path else inner


def _described(kind: type[msgspec.Struct], path: str, seen: Seen) -> Table:
    """Return the section of a table whose keys were described before, by themselves or among others."""
    where = seen.kinds[kind]
    if kind in seen.whole:
        return Table(path, "", where)
    return Table(path, _as_in(where, (field.name for field in msgspec.structs.fields(kind))))


def _as_in(where: str, names: Iterable[str]) -> str:
    return f"As in `[{where}]`: {', '.join(f'`{name}`' for name in names)}.\n"


def _about(kind: type) -> str:
    return " ".join((inspect.getdoc(kind) or "").split())


def key_table(kind: type[msgspec.Struct], leave_out: Collection[str] = (), about: str = "") -> str:
    """Return the table of a struct's keys but for those that are tables themselves; "" where there is none.

    about: what stands at its head; else what the type says of itself.
    """
    meaning, hints = field_docs(kind), get_type_hints(kind, include_extras=True)
    return markdown_table(
        ("", "", about or _about(kind)),
        (
            row(f"`{field.name}`", *_value(field, hints[field.name], meaning.get(field.name, "")))
            for field in msgspec.structs.fields(kind)
            if field.name not in leave_out and not _is_described_below(hints[field.name], meaning.get(field.name, ""))
        ),
    )


def _value(field: msgspec.structs.FieldInfo, hint: object, meaning: str) -> tuple[str, str]:
    """Return the cells of a key beside its name: default and limits, and meaning with the choices it does not name."""
    values = [str(value) for value in choices(hint)]
    if all(value in meaning for value in values):
        values = []
    says = f"{', '.join(f'`{value}`' for value in values)}. " if values else ""
    return " ".join(filter(None, (default_of(field, hint), limits(hint)))), f"{says}{meaning}".rstrip()


def _is_described_below(hint: object, meaning: str) -> bool:
    """Return whether a key is only the name of a table that has a section of its own."""
    inside = _structs_inside(hint)
    plain = inspect.isclass(hint) and issubclass(hint, msgspec.Struct)
    return bool(inside) and (plain or not meaning)


def _bases(kind: type) -> list[type]:
    """Return the settings types whose keys a type has as well."""
    return [base for base in kind.__mro__[1:] if issubclass(base, Settings) and base is not Settings]


def _unchanged(base: type, kind: type) -> list[str]:
    """Return the keys of a base that a type has with the same default."""
    own = {field.name: (field.default, field.default_factory) for field in msgspec.structs.fields(kind)}
    return [
        field.name
        for field in msgspec.structs.fields(base)
        if own[field.name] == (field.default, field.default_factory) and field.name not in kind.__annotations__
    ]


def _structs_inside(hint: object, suffix: str = "") -> list[tuple[type[msgspec.Struct], str]]:
    """Return the structs that a field may hold, and what the field's key is followed by in the table's heading."""
    if inspect.isclass(hint) and issubclass(hint, msgspec.Struct):
        return [(hint, suffix)]
    origin = get_origin(hint)
    suffix = "[]" if origin is list else ".NAME" if origin is dict else suffix
    return [found for item in get_args(hint) for found in _structs_inside(item, suffix)]
