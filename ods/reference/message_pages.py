"""Pages of the messages, and their JSON schema."""

import inspect
from typing import get_type_hints

import msgspec

from ods import messages
from ods.base.field_docs import field_docs
from ods.reference.type_names import GENERATED, choices, type_name
from ods.runtime import bus
from ods.runtime.ping_pace import LONGEST_S, PERIODS
from ods.runtime.processes import SUPERVISOR
from ods.runtime.raw_bytes import RawBytes

MESSAGES = {
    "sonar": "Sonar", "detections": "Detections", "vehicle": "Vehicle", "vetoes": "Vetoes", "obstacles": "Obstacles",
    "requests": "Health and requests", "truth": "Truth, bench only",
}  # fmt: skip
"""Pages of messages, in their order: by module of `ods.messages`, small ones together."""
HEAD = """# Messages

Generated from `ods/messages/` by `make docs`; do not edit.

Each process publishes on one ZeroMQ PUB socket, `ipc://<run_dir>/<process>.sock`, two parts a message: the topic's
name, and a msgpack map with the fields below. JSON Schema of all of them: [messages.schema.json](messages.schema.json).

The folder has mode 0750 and the sockets 0660, whatever the umask: readers must be of the group of the processes' user
(`ods` where the units run; log in again after joining). On other computers the same comes over tcp:
[network](../hardware/network.md).

"""

PACED = f"""
With a sonar that pings seldom, `ping` and `detections` are stale after {PERIODS:g} periods, {LONGEST_S:g} s at most.
"""

REQUESTS_HEAD = """
Requests go to a socket of their own, one part each way, from a ZeroMQ REQ socket (or DEALER, with an empty part first):

socket | answered by | request | answer
---|---|---|---
"""

FIELDS = """A field is a float unless its type follows the name; the schema has the limits. Where the pages say no more:

field | meaning
---|---
`seq` | Messages of this topic that the process has published, from 0.
`ping_number` | The sonar's own ping counter; -1: the list or clearance has no ping.
`t_rx_ns` | When the ping's last byte was read.
`made_ns` | When the message was made; 0: not reported.
`sigma_...` | Standard deviation of the field of this name; of a vector, in its axes.
`reason` | Why not, in plain words; empty when `ok`.
"""


def message_pages() -> dict[str, str]:
    """Return the page of topics and requests, and one for each module of messages: name and text."""
    text = HEAD + "topic | message | published by | rate | stale after\n---|---|---|---|---\n"
    for topic in bus.TOPICS.values():
        text += f"`{topic.name}` | {_link(topic.message)} | {topic.publisher} |"
        text += f" {topic.rate_hz:g}/s | {topic.stale_s:g} s\n" if topic.rate_hz else " now and then |\n"
    publishers = f"each process; `ods run` (as {SUPERVISOR}.sock) for those that are down"
    text += f"`{bus.HEALTH}` | {_link(messages.Health)} | {publishers} | {1 / bus.HEALTH_PERIOD_S:g}/s |"
    text += f" {bus.HEALTH_STALE_S:g} s\n"
    text += PACED + REQUESTS_HEAD
    for row in bus.REQUESTS.values():
        text += f"`{row.name}.sock` | {row.process} | {_link(row.request)} | {_link(row.answer)}\n"
    doc = inspect.getdoc(messages) or ""
    text += "\n" + doc.split("\n\n")[1].strip() + "\n\n" + FIELDS + "\npage | messages\n---|---\n"
    found: dict[str, list[type[msgspec.Struct]]] = {page: [] for page in MESSAGES}
    for kind in _structs():
        found[_page_of(kind)].append(kind)
    for page, kinds in found.items():
        text += f"[{MESSAGES[page]}]({page}.md) | {', '.join(kind.__name__ for kind in kinds)}\n"
    made = {
        f"messages/{page}.md": f"# {MESSAGES[page]}: messages\n\n{GENERATED} [How to read it](README.md).\n"
        + "".join(_section(kind) for kind in kinds)
        for page, kinds in found.items()
    }
    return {"messages/README.md": text, **made}


def _page_of(kind: type[msgspec.Struct]) -> str:
    module = kind.__module__.rpartition(".")[2]
    return {"raw_bytes": "sonar", "health": "requests"}.get(module, module)


def _link(kind: type[msgspec.Struct]) -> str:
    return f"[{kind.__name__}]({_page_of(kind)}.md#{kind.__name__.lower()})"


def schema() -> str:
    """Return the JSON schema of all messages."""
    _, components = msgspec.json.schema_components(_structs(), ref_template="#/$defs/{name}")
    return msgspec.json.format(msgspec.json.encode({"$defs": components}, order="deterministic")).decode() + "\n"


def _structs() -> list[type[msgspec.Struct]]:
    found = [item for item in vars(messages).values() if inspect.isclass(item) and issubclass(item, msgspec.Struct)]
    order = list(MESSAGES)
    return [*sorted(found, key=lambda kind: (order.index(_page_of(kind)), inspect.getsourcelines(kind)[1])), RawBytes]


def _section(kind: type[msgspec.Struct]) -> str:
    meaning = field_docs(kind)
    hints = get_type_hints(kind, include_extras=True)
    rows = dict[int, tuple[list[str], str]]()
    for number, field in enumerate(msgspec.structs.fields(kind)):
        said = _meaning(hints[field.name], meaning.get(field.name, ""))
        name = " ".join(filter(None, (f"`{field.name}`", _type(hints[field.name]))))
        last = rows[max(rows)] if rows else None
        if last and not said and not last[1]:  # fields whose names say it all share a row
            last[0].append(name)
        else:
            rows[number] = ([name], said)
    table = "".join(f"{', '.join(names)} | {said}".rstrip() + "\n" for names, said in rows.values())
    return f"\n## {kind.__name__}\n\n{inspect.getdoc(kind)}\n\nfield | meaning\n---|---\n{table}"


def _type(hint: object) -> str:
    """Return the type of a field; "" where it is a float, or text of which each value is named."""
    name = type_name(hint)
    return "" if name == "float" or (choices(hint) and name == "text") else name


def _meaning(hint: object, meaning: str) -> str:
    """Return what a field means, after the values that it may have and that the meaning does not name."""
    values = choices(hint)
    missing = [value for value in values if str(value) not in meaning]
    return f"{', '.join(f'`{value}`' for value in values)}. {meaning}".strip() if missing else meaning
