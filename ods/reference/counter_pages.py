"""Pages of the counters."""

from collections.abc import Iterable

from ods.reference.markdown import head, row, table
from ods.runtime.counters import COUNTERS, CounterRow

PROCESS_COUNTERS = {
    "sonar": "sonar", "tracker": "pipeline and tracker", "nav": "navigation",
    "others": "bridges, other computers, bench", "recordings": "recordings and replay",
}  # fmt: skip
"""Pages of counters: by process, and the rest by `_counter_page`."""
COUNTERS_HEAD = """# Counters

Generated from `ods/runtime/counters.py` by `make docs`.

A counter that rises means that data is lost or a device misbehaves, unless the pages say *(normal)*. Each process
sends its counters in its [health report](../messages/requests.md#health); `ods watch` shows those that are not 0, and
`ods doctor --listen` those of `sonar` and `nav`. The recorder and `ods detect` print theirs at the end.

"""
NORMAL = " *(normal)*"
COLUMNS = ("counter", "counts")


def counter_pages() -> dict[str, str]:
    """Return the index of the counters, and a page for each process or group: name and text."""
    owners = dict[str, list[str]]()
    """Who has a row, by its meaning."""
    names = dict[tuple[str, ...], dict[str, list[str]]]()
    for where, rows in COUNTERS.items():
        for name, meaning in dict.fromkeys(map(_said, rows.values())):
            owners.setdefault(f"{name} {meaning}", []).append(where)
    for rows in COUNTERS.values():
        for name, meaning in dict.fromkeys(map(_said, rows.values())):
            same = names.setdefault(tuple(owners[f"{name} {meaning}"]), {}).setdefault(meaning, [])
            if name not in same:
                same.append(name)
    sections = {_title(group): (group, _table(meanings)) for group, meanings in names.items()}
    found: dict[str, str] = dict.fromkeys(["README", *PROCESS_COUNTERS], "")
    for title, (group, text) in sections.items():
        pages = {_counter_page(where) for where in group}
        found[pages.pop() if len(pages) == 1 else "README"] += f"\n## {title}\n\n{text}"
    several = found.pop("README")
    made = {f"counters/{page}.md": head("Counters", PROCESS_COUNTERS[page]) + text for page, text in found.items()}
    index = table(("page", "counters of"), (row(f"[{_capital(PROCESS_COUNTERS[page])}]({page}.md)", _listed(page))
                                            for page in PROCESS_COUNTERS))  # fmt: skip
    return {"counters/README.md": f"{COUNTERS_HEAD}{index}{several}", **made}


def _said(counter: CounterRow) -> tuple[str, str]:
    """Return a counter's name and meaning; those of one kind, a counter for each topic, have the same ones."""
    name, meaning = counter.name, counter.meaning
    _, _, topic = name.partition("_")
    if f"`{topic}`" in meaning:
        name, meaning = name.replace(topic, "TOPIC"), meaning.replace(f"`{topic}`", "`TOPIC`")
    if counter.advice.startswith(meaning):
        meaning = counter.advice
    elif counter.advice:
        meaning += f". {_capital(counter.advice)}"
    return name, f"{meaning}{'' if counter.trouble else NORMAL}"


def _table(meanings: dict[str, list[str]]) -> str:
    """Return the table of counters by their meaning; those with the same one share a row."""
    return table(COLUMNS, (row(", ".join(f"`{name}`" for name in names), meaning)
                           for meaning, names in meanings.items()))  # fmt: skip


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
