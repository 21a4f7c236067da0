"""Parts of a page in Markdown."""

import re
from collections.abc import Iterable, Sequence


def head(folder: str, title: str) -> str:
    """Return the head of a generated page; the README of its folder says how to read it."""
    return f"# [{folder}](README.md): {title}\n"


def table(columns: Iterable[str], rows: Iterable[str]) -> str:
    """Return a table of rows made by `row`; "" where there is none."""
    names = list(columns)
    text = "".join(rows)
    return f"{_header(names)}{'|'.join(['---'] * len(names))}\n{text}" if text else ""


def _header(names: Sequence[str]) -> str:
    """Return the header; where only the last column has a name, its bars begin the line."""
    return f"{'|' * len(names)}{names[-1]}\n" if not any(names[:-1]) else row(*names)


def row(*cells: str) -> str:
    """Return one row; empty cells at its end are left out."""
    return re.sub(r"\| (?=\|)", "|", " |".join(cells)).rstrip(" |") + "\n"
