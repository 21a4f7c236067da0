"""Pages of the counters."""

from ods.reference.type_names import GENERATED
from ods.runtime.counters import COUNTERS, CounterRow

PROCESS_COUNTERS = {
    "sonar": "Sonar", "tracker": "Pipeline and tracker", "nav": "Navigation",
    "others": "Bridges, other computers, bench", "recordings": "Recordings and replay",
}  # fmt: skip
"""Pages of counters: by process, and the rest by `_counter_page`."""
COUNTERS_HEAD = """# Counters

Generated from the table in `ods/runtime/counters.py` by `make docs`; do not edit.

Every kind of loss has a counter of its own. Each process sends its counters in its
[health report](../messages/requests.md#health), and `ods watch` shows those that are not 0. The recorder prints its
counters in its summary, `ods detect` those of the file it reads.

What counts means that data is lost or a device misbehaves, except where the pages say *(normal)*. `ods doctor --listen`
notes the losses of `sonar` and `nav`.
"""
TABLE = "counter | counts\n---|---\n"
NORMAL = " *(normal)*"


def counter_pages() -> dict[str, str]:
    """Return the index of the counters, and a page for each process or group: name and text."""
    lines = {where: list(dict.fromkeys(map(_line, rows.values()))) for where, rows in COUNTERS.items()}
    everywhere = [line for each in lines.values() for line in each]
    shared = {line for line in everywhere if everywhere.count(line) > 1}
    found: dict[str, str] = dict.fromkeys(PROCESS_COUNTERS, "")
    listed: dict[str, list[str]] = {page: [] for page in PROCESS_COUNTERS}
    for where, own in lines.items():
        page = _counter_page(where)
        listed[page].append(where)
        rows = "".join(line for line in own if line not in shared)
        found[page] += f"\n## {where}\n\n{TABLE}{rows}" if rows else ""
    made = {
        f"counters/{page}.md": f"# {PROCESS_COUNTERS[page]}: counters\n\n{GENERATED} "
        f"[How to read it, and what several processes count](README.md).\n{text}"
        for page, text in found.items()
    }
    several = "".join(
        f"{line.rstrip()} ({', '.join(where for where in lines if line in lines[where])})\n"
        for line in dict.fromkeys(everywhere)
        if line in shared
    )
    index = "".join(f"[{PROCESS_COUNTERS[page]}]({page}.md) | {', '.join(listed[page])}\n" for page in found)
    text = f"{COUNTERS_HEAD}\npage | counters of\n---|---\n{index}\n## What several processes count\n\n{TABLE}{several}"
    return {"counters/README.md": text, **made}


def _line(row: CounterRow) -> str:
    """Return the row of a counter; those of one kind, a counter for each topic, have the same one."""
    name, meaning = row.name, row.meaning
    _, _, topic = name.partition("_")
    if f"`{topic}`" in meaning:
        name, meaning = name.replace(topic, "TOPIC"), meaning.replace(f"`{topic}`", "`TOPIC`")
    advice = f". {row.advice[:1].upper()}{row.advice[1:]}" if row.advice else ""
    return f"`{name}` | {meaning}{advice}{'' if row.trouble else NORMAL}\n"


def _counter_page(where: str) -> str:
    if where in PROCESS_COUNTERS:
        return where
    if where == "pipeline":
        return "tracker"
    return "recordings" if "record" in where or "replay" in where else "others"
