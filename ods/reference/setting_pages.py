"""Pages of the configuration."""

import inspect
from collections.abc import Collection
from typing import get_args, get_origin, get_type_hints

import msgspec

from ods.base.field_docs import field_docs
from ods.bench.settings import BenchConfig
from ods.config import OnboardConfig
from ods.reference.type_names import GENERATED, type_name

SETTINGS = {
    "vehicle": "Vehicle, bus and recordings", "sonar": "Line to the sonar", "sonars": "Settings by kind of sonar",
    "nav": "Navigation", "canopen": "INS by CANopen", "dbc": "INS by a DBC file", "nmea": "INS by NMEA 0183",
    "pipeline": "Detection", "tracker": "Tracker", "lists": "Obstacle list, clearance and map",
    "bridges": "Bridges", "bench": "Bench: simulation and limits", "planner": "Bench: planner",
}  # fmt: skip
"""Pages of settings, in their order."""
TABLES = {
    "sonar": "sonar", "sonar.s7k": "sonars", "sonar.oculus": "sonars", "sonar.norbit": "sonars",
    "sonar.ping360": "sonars", "sonar.sonar3d15": "sonars", "nav": "nav", "nav.canopen": "canopen", "nav.dbc": "dbc",
    "nav.nmea": "nmea", "pipeline": "pipeline", "tracker": "tracker", "tracker.planner": "lists",
    "tracker.bottom": "lists", "tracker.surface": "lists", "tracker.clearance": "lists", "tracker.map": "lists",
    "bridge": "bridges", "sim": "bench", "limits": "bench", "kill": "bench", "planner": "planner",
}  # fmt: skip
"""Page of each table and of those inside it; all others: "vehicle"."""
CONFIG_HEAD = """# Configuration

Generated from the settings types by `make docs`; do not edit.

Files are TOML. An unknown key, a wrong type or a value out of range is one line that names the file and the key, and
exit code 2. Relative paths are relative to the file's own folder; `~` is the user's home. In brackets: the usual range
and its unit. The workbench's slider covers that range; values outside are accepted, and `ods doctor` notes them.
"""


def setting_pages() -> dict[str, str]:
    """Return the index of the tables, and a page for each group of them: name and text."""
    found: dict[str, str] = dict.fromkeys(SETTINGS, "")
    named: dict[str, list[str]] = {page: [] for page in SETTINGS}
    seen: dict[type[msgspec.Struct], str] = {}
    for config in (OnboardConfig, BenchConfig):
        for path, text in tables(config, "", seen):
            page = next((TABLES[each] for each in _parents(path) if each in TABLES), "vehicle")
            found[page] += text
            named[page] += [f"`{path}`"] if path.count(".") == 0 or path in TABLES else []
    rows = "".join(f"| [{SETTINGS[page]}]({page}.md) | {', '.join(named[page])} |\n" for page in SETTINGS)
    rows += "| [Equalizers and filters](stages.md), [detectors](detectors.md) "
    rows += "| `pipeline.stage[]` |\n"
    rows += "| [Scene files](scene.md), [their images](image.md) | config/scenes/*.toml |\n"
    rows += "| [Sonar files](sonar-file.md) | config/sonars/*.toml |\n"
    made = {
        f"configuration/{page}.md": f"# {SETTINGS[page]}: configuration\n\n{GENERATED} "
        f"[How to read it, and all tables](README.md).\n{text}"
        for page, text in found.items()
    }
    return {"configuration/README.md": f"{CONFIG_HEAD}\n| page | tables |\n|---|---|\n{rows}", **made}


def _parents(path: str) -> list[str]:
    """Return a table's path and those of the tables that it is in, the longest first."""
    parts = path.replace("[]", "").split(".")
    return [".".join(parts[:n]) for n in range(len(parts), 0, -1)]


def tables(kind: type[msgspec.Struct], path: str, seen: dict[type[msgspec.Struct], str]) -> list[tuple[str, str]]:
    """Return path and section of one TOML table and of the tables inside it; one that was there is only named."""
    if path and kind in seen:
        same = f"\n## [{path}]\n\n{inspect.getdoc(kind)} Its keys are those of `[{seen[kind]}]`.\n"
        return [(path, same)] if seen[kind] != path else []
    seen[kind] = path
    hints = get_type_hints(kind, include_extras=True)
    inner = list[tuple[str, str]]()
    for field in msgspec.structs.fields(kind):
        for item, suffix in _structs_inside(hints[field.name]):
            inner += tables(item, f"{path}.{field.name}".lstrip(".") + suffix, seen)
    table = key_table(kind)
    head = f"\n## [{path}]\n\n{inspect.getdoc(kind)}\n"
    return [(path, head + (f"\n{table}" if table else "")), *inner] if path else inner


def key_table(kind: type[msgspec.Struct], leave_out: Collection[str] = ()) -> str:
    """Return the table of a struct's keys but for those that are tables themselves; "" where there is none."""
    meaning, hints = field_docs(kind), get_type_hints(kind, include_extras=True)
    rows = "".join(
        f"| `{field.name}` | {type_name(hint)} | {_default(field)} | {meaning.get(field.name, '')} |\n"
        for field in msgspec.structs.fields(kind)
        if field.name not in leave_out
        and not (inspect.isclass(hint := hints[field.name]) and issubclass(hint, msgspec.Struct))
    )
    return f"| key | type | default | meaning |\n|---|---|---|---|\n{rows}" if rows else ""


def _structs_inside(hint: object, suffix: str = "") -> list[tuple[type[msgspec.Struct], str]]:
    """Return the structs that a field may hold, and what the field's key is followed by in the table's heading."""
    if inspect.isclass(hint) and issubclass(hint, msgspec.Struct):
        return [(hint, suffix)]
    origin = get_origin(hint)
    suffix = "[]" if origin is list else ".NAME" if origin is dict else suffix
    return [found for item in get_args(hint) for found in _structs_inside(item, suffix)]


def _default(field: msgspec.structs.FieldInfo) -> str:
    if field.required:
        return "required"
    if inspect.isfunction(field.default_factory):  # it depends on the machine
        return "see there"
    value = field.default if field.default is not msgspec.NODEFAULT else field.default_factory()
    return f"`{value}`" if len(f"{value}") < 60 else "see there"
