"""Writes docs/messages.md and docs/messages.schema.json from the message types: `python -m ods.message_docs docs`."""

import ast
import inspect
import sys
from itertools import pairwise
from pathlib import Path
from typing import get_type_hints

import msgspec

from ods import bus, messages
from ods.processes import PROCESSES

HEAD = """# Messages

Generated from `ods/messages.py` by `make docs`; do not edit.

Each process publishes on one ZeroMQ PUB socket, `ipc://<run_dir>/<process>.sock`, two parts a message: the topic's
name, and a msgpack map with the fields below. JSON Schema of all of them: [messages.schema.json](messages.schema.json).

"""


def markdown() -> str:
    """Return the text of docs/messages.md."""
    text = HEAD + "| topic | message | published by | rate | stale after |\n|---|---|---|---|---|\n"
    for topic in bus.TOPICS.values():
        name = topic.message.__name__
        text += f"| `{topic.name}` | [{name}](#{name.lower()}) | {topic.publisher} | {topic.rate_hz:g}/s |"
        text += f" {topic.stale_s:g} s |\n"
    text += f"| `{bus.HEALTH}` | [Health](#health) | {', '.join(PROCESSES)} | {1 / bus.HEALTH_PERIOD_S:g}/s |"
    text += f" {bus.HEALTH_STALE_S:g} s |\n"
    doc = inspect.getdoc(messages) or ""
    return text + "\n" + doc.split("\n\n")[1].strip() + "\n" + "".join(_section(kind) for kind in _structs())


def schema() -> str:
    """Return the text of docs/messages.schema.json."""
    _, components = msgspec.json.schema_components(_structs(), ref_template="#/$defs/{name}")
    return msgspec.json.format(msgspec.json.encode({"$defs": components}, order="deterministic")).decode() + "\n"


def _structs() -> list[type[msgspec.Struct]]:
    found = [item for item in vars(messages).values() if inspect.isclass(item) and issubclass(item, msgspec.Struct)]
    return sorted(found, key=lambda kind: inspect.getsourcelines(kind)[1])


def _section(kind: type[msgspec.Struct]) -> str:
    meaning = _field_docs(kind)
    hints = get_type_hints(kind)
    rows = "".join(
        f"| `{field.name}` | {_type_name(hints[field.name])} | {meaning.get(field.name, '')} |\n"
        for field in msgspec.structs.fields(kind)
    )
    return f"\n## {kind.__name__}\n\n{inspect.getdoc(kind)}\n\n| field | type | meaning |\n|---|---|---|\n{rows}"


def _field_docs(kind: type[msgspec.Struct]) -> dict[str, str]:
    """Return the strings that stand below each field."""
    (tree,) = ast.parse(inspect.getsource(kind)).body
    body = tree.body if isinstance(tree, ast.ClassDef) else []
    docs: dict[str, str] = {}
    for field, below in pairwise(body):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(below, ast.Expr):
            docs[field.target.id] = " ".join(ast.literal_eval(below.value).split())
    return docs


def _type_name(hint: object) -> str:
    name = getattr(hint, "__name__", "") if isinstance(hint, type) and not hasattr(hint, "__args__") else str(hint)
    return name.replace("typing.", "").replace("ods.messages.", "").replace("|", "or")


def main() -> None:
    """Write both files into the folder named on the command line."""
    folder = Path(sys.argv[1])
    (folder / "messages.md").write_text(markdown(), encoding="utf-8")
    (folder / "messages.schema.json").write_text(schema(), encoding="utf-8")


if __name__ == "__main__":
    main()
