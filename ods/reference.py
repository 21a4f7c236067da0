"""Writes the reference pages in docs/ from the message and settings types: `make docs`."""

import inspect
import sys
from pathlib import Path
from types import UnionType
from typing import Annotated, Literal, Union, get_args, get_origin, get_type_hints

import msgspec

from ods import messages
from ods.base.field_docs import field_docs
from ods.base.settings import Slider
from ods.bench.settings import BenchConfig
from ods.config import OnboardConfig
from ods.runtime import bus
from ods.runtime.counters import COUNTERS
from ods.runtime.ping_pace import LONGEST_S, PERIODS
from ods.runtime.processes import PROCESSES, SUPERVISOR
from ods.runtime.raw_bytes import RawBytes

PAGE = [f"ods.messages.{name}" for name in
        ("sonar", "detections", "vehicle", "vetoes", "obstacles", "requests", "health", "truth")]  # fmt: skip
"""Modules of messages, in the order of the page."""
HEAD = """# Messages

Generated from `ods/messages/` by `make docs`; do not edit.

Each process publishes on one ZeroMQ PUB socket, `ipc://<run_dir>/<process>.sock`, two parts a message: the topic's
name, and a msgpack map with the fields below. JSON Schema of all of them: [messages.schema.json](messages.schema.json).

The folder has mode 0750 and the sockets 0660, whatever the umask: readers must be of the group of the processes' user
(`ods` where the units run; log in again after joining). On other computers the same comes over tcp:
[network.md](network.md).

"""

PACED = f"""
With a sonar that pings seldom, `ping` and `detections` are stale after {PERIODS:g} periods, {LONGEST_S:g} s at most.
"""

REQUESTS_HEAD = """
Requests go to a socket of their own, one part each way, from a ZeroMQ REQ socket (or DEALER, with an empty part first):

| socket | answered by | request | answer |
|---|---|---|---|
"""

CONFIG_HEAD = """# Configuration

Generated from the settings types by `make docs`; do not edit.

Files are TOML. An unknown key, a wrong type or a value out of range is one line that names the file and the key, and
exit code 2. Relative paths are relative to the file's own folder; `~` is the user's home. In brackets: the usual range
and its unit. The workbench's slider covers that range; values outside are accepted, and `ods doctor` notes them.
"""

COUNTERS_HEAD = """# Counters

Generated from the table in `ods/runtime/counters.py` by `make docs`; do not edit.

Every kind of loss has a counter of its own. Each process sends its counters in its [health report](messages.md#health),
and `ods watch` shows those that are not 0. The recorder prints its counters in its summary, `ods detect` those of the
file it reads.
**Trouble**: data is lost, or a device misbehaves; `ods doctor --listen` notes those of `sonar` and `nav`.
**Logged**: the first occurrence is a line in the log.
"""


def pages() -> dict[str, str]:
    """Return every generated file of docs/: name and text."""
    return {
        "messages.md": _messages(),
        "messages.schema.json": _schema(),
        "configuration.md": _configuration(),
        "counters.md": _counters(),
    }


def _messages() -> str:
    text = HEAD + "| topic | message | published by | rate | stale after |\n|---|---|---|---|---|\n"
    for topic in bus.TOPICS.values():
        name = topic.message.__name__
        text += f"| `{topic.name}` | [{name}](#{name.lower()}) | {topic.publisher} |"
        text += f" {topic.rate_hz:g}/s | {topic.stale_s:g} s |\n" if topic.rate_hz else " now and then | |\n"
    publishers = f"{', '.join(PROCESSES)}; `ods run` (as {SUPERVISOR}.sock) for those that are down"
    text += f"| `{bus.HEALTH}` | [Health](#health) | {publishers} | {1 / bus.HEALTH_PERIOD_S:g}/s |"
    text += f" {bus.HEALTH_STALE_S:g} s |\n"
    text += PACED + REQUESTS_HEAD
    for row in bus.REQUESTS.values():
        asked, given = row.request.__name__, row.answer.__name__
        text += f"| `{row.name}.sock` | {row.process} | [{asked}](#{asked.lower()}) | [{given}](#{given.lower()}) |\n"
    doc = inspect.getdoc(messages) or ""
    return text + "\n" + doc.split("\n\n")[1].strip() + "\n" + "".join(_section(kind) for kind in _structs())


def _schema() -> str:
    _, components = msgspec.json.schema_components(_structs(), ref_template="#/$defs/{name}")
    return msgspec.json.format(msgspec.json.encode({"$defs": components}, order="deterministic")).decode() + "\n"


def _structs() -> list[type[msgspec.Struct]]:
    found = [item for item in vars(messages).values() if inspect.isclass(item) and issubclass(item, msgspec.Struct)]
    return [*sorted(found, key=lambda kind: (PAGE.index(kind.__module__), inspect.getsourcelines(kind)[1])), RawBytes]


def _section(kind: type[msgspec.Struct]) -> str:
    meaning = field_docs(kind)
    hints = get_type_hints(kind, include_extras=True)
    rows = "".join(
        f"| `{field.name}` | {_type_name(hints[field.name])} | {meaning.get(field.name, '')} |\n"
        for field in msgspec.structs.fields(kind)
    )
    return f"\n## {kind.__name__}\n\n{inspect.getdoc(kind)}\n\n| field | type | meaning |\n|---|---|---|\n{rows}"


def _type_name(hint: object) -> str:
    """Return a type as a reader of the docs would say it, ranges included."""
    if get_origin(hint) is Annotated:
        kind, *extras = get_args(hint)
        return " ".join([_type_name(kind), *(bound for extra in extras for bound in _bounds(extra))])
    if get_origin(hint) is Literal:
        return " or ".join(f"`{value}`" for value in get_args(hint))
    if get_origin(hint) in (UnionType, Union):
        return " or ".join(_type_name(item) for item in get_args(hint))
    if get_args(hint):
        inside = ", ".join(_type_name(item) for item in get_args(hint))
        return f"{getattr(get_origin(hint), '__name__', '')}[{inside}]"
    return "none" if hint is type(None) else "..." if hint is ... else getattr(hint, "__name__", str(hint))


def _bounds(meta: object) -> list[str]:
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    values = {sign: getattr(meta, name, None) for name, sign in signs.items()}
    extra = getattr(meta, "extra", None) or {}
    odd = ["odd"] if extra.get("odd") else []
    bounds = [f"{sign} {value:g}" for sign, value in values.items() if value is not None]
    return [*odd, *bounds, *([_shown(extra["slider"])] if "slider" in extra else [])]


def _shown(slider: Slider) -> str:
    ends = f"{slider.low:g} to {slider.high:g}"
    return f"({', '.join(filter(None, (ends, 'logarithmic' if slider.log else '', slider.unit)))})"


def _configuration() -> str:
    text = CONFIG_HEAD
    for title, kind in (("On board: config/onboard.toml", OnboardConfig), ("Bench: config/bench.toml", BenchConfig)):
        text += f"\n# {title}\n" + _table(kind, "")
    return text


def _table(kind: type[msgspec.Struct], path: str) -> str:
    """Return the section of one TOML table and of the tables inside it."""
    meaning = field_docs(kind)
    hints = get_type_hints(kind, include_extras=True)
    rows, inner = "", ""
    for field in msgspec.structs.fields(kind):
        hint = hints[field.name]
        if inspect.isclass(hint) and issubclass(hint, msgspec.Struct):
            inner += _table(hint, f"{path}.{field.name}" if path else field.name)
        else:
            rows += f"| `{field.name}` | {_type_name(hint)} | {_default(field)} | {meaning.get(field.name, '')} |\n"
            key = f"{path}.{field.name}".lstrip(".")
            inner += "".join(_table(item, key + suffix) for item, suffix in _structs_inside(hint))
    head = f"\n## [{path}]\n\n{inspect.getdoc(kind)}\n" if path else ""
    return head + (f"\n| key | type | default | meaning |\n|---|---|---|---|\n{rows}" if rows else "") + inner


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


def _counters() -> str:
    text = COUNTERS_HEAD
    for where, rows in COUNTERS.items():
        text += f"\n## {where}\n\n| counter | counts | trouble | logged |\n|---|---|---|---|\n"
        for row in rows.values():
            counts = row.meaning + (f". Advice: {row.advice}" if row.advice else "")
            text += f"| `{row.name}` | {counts} | {'yes' if row.trouble else ''} | {'yes' if row.logged else ''} |\n"
    return text


def main() -> None:
    """Write all pages into the folder named on the command line."""
    for name, text in pages().items():
        (Path(sys.argv[1]) / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
