"""Pages of the messages, and their JSON schema."""

import inspect
from typing import get_type_hints

import msgspec

from ods import messages
from ods.base.field_docs import field_docs
from ods.reference.markdown import head, row, table
from ods.reference.type_names import choices, type_name
from ods.runtime import bus
from ods.runtime.ping_pace import LONGEST_S, PERIODS
from ods.runtime.processes import SUPERVISOR
from ods.runtime.raw_bytes import RawBytes

MESSAGES = {
    "sonar": "sonar", "detections": "detections", "vehicle": "vehicle", "obstacles": "obstacles",
    "requests": "health, requests and vetoes", "truth": "truth, bench only",
}  # fmt: skip
"""Pages of messages, in their order: by module of `ods.messages`, small ones together."""
HEAD = """# Messages

For planner developers. Generated from `ods/messages/` by `make docs`.

Each process publishes on one ZeroMQ PUB socket, `ipc://<run_dir>/<process>.sock`, each message in two parts: the
topic's name, and a msgpack map of fields ([JSON Schema](messages.schema.json)).

The folder has mode 0750 and the sockets 0660: readers must be of the group of the processes' user (`ods` where the
units run; log in again after joining). Other computers get the same [over tcp](../hardware/network.md).

"""

PACED = f"""
With a slow sonar, `ping` and `detections` are stale after {PERIODS:g} periods, {LONGEST_S:g} s at most.
A planner without `ods.client` must set a receive time-out: silence means that the last list is not valid.
"""

REQUESTS_HEAD = """
Requests go to sockets of their own, one part each way, from a ZeroMQ REQ socket (or DEALER, with an empty part first):

"""

SHARED = {
    "seq": ("int", "Messages of this topic published by this process before."),
    "ping_number": ("int", "The sonar's own ping counter; -1: the list or clearance has no ping."),
    "t_rx_ns": ("", "When the ping's last byte was read."),
    "made_ns": ("", "When the message was made; 0: not reported."),
    "utc_source": ("text", "`clock`, `ins`, `unsure`: UTC is this computer's, the INS's, or unreliable."),
    "position_ned": ("float[3]", "m."),
    "attitude": ("float[4]", "Quaternion w, x, y, z, body to global."),
    "sound_speed": ("", "m/s."),
    "sigma_...": ("", "Standard deviation of the field of this name; of a vector, in its axes."),
    "reason": ("text", "Why the request failed; empty when `ok`."),
}
"""Types and meanings of fields that several messages have."""

FIELDS = """A field is a float unless its type follows: `float[3]` are three, `text[]` a list, `?` may be none; the
schema has the limits. Fields without a description mean:

"""
COLUMNS = ("field", "meaning")
INTEGERS = "_ns"
"""Ending of the names of fields that are integers."""


def message_pages() -> dict[str, str]:
    """Return the page of topics and requests, and one for each module of messages: name and text."""
    topics = [
        row(f"`{topic.name}`", _link(topic.message), topic.publisher, *_pace(topic.rate_hz, topic.stale_s))
        for topic in bus.TOPICS.values()
    ]
    publishers = f"each process; `ods run` (as {SUPERVISOR}.sock) for those that are down"
    health = _pace(1 / bus.HEALTH_PERIOD_S, bus.HEALTH_STALE_S)
    topics.append(row(f"`{bus.HEALTH}`", _link(messages.Health), publishers, *health))
    requests = [
        row(f"`{each.name}.sock`", each.process, _link(each.request), _link(each.answer))
        for each in bus.REQUESTS.values()
    ]
    found: dict[str, list[type[msgspec.Struct]]] = {page: [] for page in MESSAGES}
    for kind in _structs():
        found[_page_of(kind)].append(kind)
    index = (
        f"{HEAD}{table(('topic', 'message', 'published by', 'rate', 'stale after'), topics)}{PACED}{REQUESTS_HEAD}"
        f"{table(('socket', 'answered by', 'request', 'answer'), requests)}\n{_conventions()}\n\n{FIELDS}"
        f"{table(COLUMNS, (row(f'`{name}` {kind}'.rstrip(), meaning) for name, (kind, meaning) in SHARED.items()))}"
    )
    return {"messages/README.md": index} | {
        f"messages/{page}.md": head("Messages", MESSAGES[page]) + "".join(map(_section, kinds))
        for page, kinds in found.items()
    }


def _pace(rate_hz: float | None, stale_s: float | None) -> tuple[str, str]:
    return (f"{rate_hz:g}/s", f"{stale_s:g} s") if rate_hz else ("", "")


def _conventions() -> str:
    return (inspect.getdoc(messages) or "").split("\n\n")[1].strip()


def _page_of(kind: type[msgspec.Struct]) -> str:
    module = kind.__module__.rpartition(".")[2]
    return {"raw_bytes": "sonar", "health": "requests", "vetoes": "requests"}.get(module, module)


def _link(kind: type[msgspec.Struct]) -> str:
    return f"[{kind.__name__}]({_page_of(kind)}.md#{kind.__name__.lower()})"


def schema() -> str:
    """Return the JSON schema of all messages."""
    _, components = msgspec.json.schema_components(_structs(), ref_template="#/$defs/{name}")
    return msgspec.json.format(msgspec.json.encode({"$defs": components}, order="deterministic")).decode() + "\n"


def _structs() -> list[type[msgspec.Struct]]:
    found = [item for item in vars(messages).values() if inspect.isclass(item) and issubclass(item, msgspec.Struct)]
    order = list(MESSAGES)
    return [*sorted(found, key=lambda kind: (order.index(_page_of(kind)), kind.__module__, _line(kind))), RawBytes]


def _line(kind: type) -> int:
    return inspect.getsourcelines(kind)[1]


def _section(kind: type[msgspec.Struct]) -> str:
    meaning = field_docs(kind)
    hints = get_type_hints(kind, include_extras=True)
    rows = list[tuple[list[str], str]]()
    for field in msgspec.structs.fields(kind):
        said = _meaning(field.name, hints[field.name], meaning.get(field.name, ""))
        name = " ".join(filter(None, (f"`{field.name}`", _type(field.name, hints[field.name]))))
        if rows and not said and not rows[-1][1]:  # fields whose names say it all share a row
            rows[-1][0].append(name)
        else:
            rows.append(([name], said))
    about, _, details = (inspect.getdoc(kind) or "").partition("\n\n")
    fields = table(("", " ".join(about.split())), (row(", ".join(names), said) for names, said in rows))
    return f"\n## {kind.__name__}\n\n{fields}" + (f"\n{details}\n" if details else "")


def _type(name: str, hint: object) -> str:
    """Return the type of a field; "" where its name says it, it is a float, or text of which each value is named."""
    found = type_name(hint)
    known = name in SHARED or (name.endswith(INTEGERS) and found == "int")
    return "" if known or found == "float" or (choices(hint) and found == "text") else found


def _meaning(name: str, hint: object, meaning: str) -> str:
    """Return what a field means, after the values that it may have and that the meaning does not name."""
    values = choices(hint)
    if name in SHARED or all(str(value) in meaning for value in values):
        return meaning
    return f"{', '.join(f'`{value}`' for value in values)}. {meaning}".strip()
