"""Pages of the counters."""

from ods.reference.type_names import GENERATED
from ods.runtime.counters import COUNTERS

PROCESS_COUNTERS = {
    "sonar": "Sonar", "pipeline": "Pipeline", "tracker": "Tracker", "nav": "Navigation",
    "others": "Bridges, other computers, bench", "recordings": "Recordings and replay",
}  # fmt: skip
"""Pages of counters: by process, and the rest by `_counter_page`."""
COUNTERS_HEAD = """# Counters

Generated from the table in `ods/runtime/counters.py` by `make docs`; do not edit.

Every kind of loss has a counter of its own. Each process sends its counters in its
[health report](../messages/health.md#health), and `ods watch` shows those that are not 0. The recorder prints its
counters in its summary, `ods detect` those of the file it reads.
**Trouble**: data is lost, or a device misbehaves; `ods doctor --listen` notes those of `sonar` and `nav`.
**Logged**: the first occurrence is a line in the log.
"""


def counter_pages() -> dict[str, str]:
    """Return the index of the counters, and a page for each process or group: name and text."""
    found: dict[str, str] = dict.fromkeys(PROCESS_COUNTERS, "")
    names: dict[str, list[str]] = {}
    for where, rows in COUNTERS.items():
        table = "| counter | counts | trouble | logged |\n|---|---|---|---|\n"
        for row in rows.values():
            counts = row.meaning + (f". Advice: {row.advice}" if row.advice else "")
            table += f"| `{row.name}` | {counts} | {'yes' if row.trouble else ''} | {'yes' if row.logged else ''} |\n"
        names.setdefault(table, []).append(where)
    listed: dict[str, list[str]] = {page: [] for page in PROCESS_COUNTERS}
    for table, alike in names.items():
        page = _counter_page(alike[0])
        found[page] += f"\n## {', '.join(alike)}\n\n{table}"
        listed[page].extend(alike)
    lines = "".join(f"| [{PROCESS_COUNTERS[page]}]({page}.md) | {', '.join(listed[page])} |\n" for page in found)
    made = {
        f"counters/{page}.md": f"# {PROCESS_COUNTERS[page]}: counters\n\n{GENERATED} "
        f"[What the columns mean](README.md).\n{text}"
        for page, text in found.items()
    }
    return {"counters/README.md": f"{COUNTERS_HEAD}\n| page | counters of |\n|---|---|\n{lines}", **made}


def _counter_page(where: str) -> str:
    if where in PROCESS_COUNTERS:
        return where
    return "recordings" if "record" in where or "replay" in where else "others"
