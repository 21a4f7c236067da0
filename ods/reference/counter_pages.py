"""Pages of the counters."""

from collections.abc import Iterable
from typing import NamedTuple

from ods.reference.markdown import head, row, table
from ods.runtime.counters import COUNTERS, CounterRow

PROCESS_COUNTERS = {
    "sonar": "sonar", "tracker": "pipeline and tracker", "nav": "navigation",
    "others": "bridges, other computers, bench", "recordings": "recordings and replay",
}  # fmt: skip
"""Pages of counters: by process, and the rest by `_counter_page`."""
COUNTERS_HEAD = """# Counters

For operators. Generated from `ods/runtime/counters.py` by `make docs`.

A counter under *trouble* increases when data is lost or a device misbehaves. Each process sends its counters in its
[health report](../messages/requests.md#health); `ods watch` shows those that are not 0, `ods doctor --listen` those
of `sonar` and `nav`. The recorder and `ods detect` print theirs at the end.

"""


class Line(NamedTuple):
    """A counter as the pages show it."""

    name: str
    meaning: str
    trouble: bool


def counter_pages() -> dict[str, str]:
    """Return the index of the counters, and a page for each process or group: name and text."""
    owners = dict[Line, list[str]]()
    for where, rows in COUNTERS.items():
        for line in dict.fromkeys(map(_line, rows.values())):
            owners.setdefault(line, []).append(where)
    groups = dict[tuple[str, ...], list[Line]]()
    for line, group in owners.items():
        groups.setdefault(tuple(group), []).append(line)
    found: dict[str, str] = dict.fromkeys(["README", *PROCESS_COUNTERS], "")
    for wheres, lines in groups.items():
        pages = {_counter_page(where) for where in wheres}
        found[pages.pop() if len(pages) == 1 else "README"] += f"\n## {_title(wheres)}\n\n{_tables(lines)}"
    several = found.pop("README")
    index = table(
        ("page", "counters of"),
        (row(f"[{_capital(title)}]({page}.md)", _listed(page)) for page, title in PROCESS_COUNTERS.items()),
    )
    return {"counters/README.md": f"{COUNTERS_HEAD}{index}{several}"} | {
        f"counters/{page}.md": head("Counters", PROCESS_COUNTERS[page]) + text for page, text in found.items()
    }


def _line(counter: CounterRow) -> Line:
    """Return the line of a counter; those of one kind, a counter for each topic, have the same one."""
    name, meaning = counter.name, counter.meaning
    _, _, topic = name.partition("_")
    if f"`{topic}`" in meaning:
        name, meaning = name.replace(topic, "TOPIC"), meaning.replace(f"`{topic}`", "`TOPIC`")
    if counter.advice.startswith(meaning):
        meaning = counter.advice
    elif counter.advice:
        meaning += f". {_capital(counter.advice)}"
    return Line(name, meaning, counter.trouble)


def _tables(lines: Iterable[Line]) -> str:
    """Return the table of the counters that mean trouble, and that of the others; same meanings share a row."""
    names: dict[bool, dict[str, list[str]]] = {True: {}, False: {}}
    for line in lines:
        names[line.trouble].setdefault(line.meaning, []).append(f"`{line.name}`")
    tables = (
        table(("", title), (row(", ".join(same), meaning) for meaning, same in names[trouble].items()))
        for trouble, title in ((True, "trouble"), (False, "normal"))
    )
    return "\n".join(filter(None, tables))


def _title(group: Iterable[str]) -> str:
    bridges = {where for where in COUNTERS if where.startswith("bridge_")}
    others = [where for where in group if where not in bridges]
    own = [where for where in group if where in bridges]
    return ", ".join((["bridges"] if len(own) == len(bridges) else own) + others)


def _listed(page: str) -> str:
    return _title([where for where in COUNTERS if _counter_page(where) == page])


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _counter_page(where: str) -> str:
    if where in PROCESS_COUNTERS:
        return where
    if where == "pipeline":
        return "tracker"
    return "recordings" if "record" in where or "replay" in where else "others"
