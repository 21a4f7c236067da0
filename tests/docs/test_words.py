"""Words that the glossary replaced do not come back in what users read: pages, messages, log lines, help."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

PROJECT = Path(__file__).parents[2]
REPLACED = re.compile(
    r"\b(tells?|told|said once|echoes of nothing|carried on|blips?|wanders?|creeps?|crowds?|flickers?|doubts?"
    r"|afresh|anew|mend(s|ed|ing)?|lying frames?|(that|which) (is|are) none|objects at rest)\b",
    re.IGNORECASE,
)
CODE = re.compile(r"^```.*?^```$|^    .*?$|`[^`\n]*`|\]\([^)\s]*\)", re.MULTILINE | re.DOTALL)
NO_PROSE = {"docs/glossary.md": "names the words"}
FEWEST_WORDS = 3
"""Of a text; shorter strings are names and values."""


def pages() -> Iterator[Path]:
    """Yield every page that is written by hand or made of docstrings."""
    yield from (PROJECT / "README.md", PROJECT / "CONTRIBUTING.md")
    yield from (page for page in sorted((PROJECT / "docs").rglob("*.md")) if _name(page) not in NO_PROSE)


def texts(file: Path) -> Iterator[str]:
    """Yield the literal texts of a module that are no docstrings: errors, log lines, help, labels."""
    for node in ast.walk(ast.parse(file.read_text())):
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Constant) and isinstance(child.value, str) and not isinstance(node, ast.Expr):
                yield child.value


def _name(path: Path) -> str:
    return path.relative_to(PROJECT).as_posix()


def found(names: Iterator[tuple[Path, str]]) -> list[str]:
    """Return the replaced words of these texts, with their files."""
    return [f"{_name(path)}: {match[0]}" for path, text in names for match in REPLACED.finditer(text)]


def test_pages_have_no_replaced_word() -> None:
    assert found((page, CODE.sub("", page.read_text())) for page in pages()) == []


def test_messages_have_no_replaced_word() -> None:
    read = ((file, text) for file in sorted((PROJECT / "ods").rglob("*.py")) for text in texts(file))
    assert found((file, text) for file, text in read if len(text.split()) >= FEWEST_WORDS) == []


def test_a_replaced_word_is_found() -> None:
    page = PROJECT / "README.md"
    assert found(iter([(page, "The sonar told its range, as `told` says.")])) == ["README.md: told", "README.md: told"]
    assert found(iter([(page, CODE.sub("", "It has `told`, [so](told.md):\n\n    told = 1\n"))])) == []
    read = list(texts(Path(__file__)))
    assert "a text of this module" in read
    assert __doc__ not in read
