"""Parts of a page in Markdown."""

import re
from collections.abc import Iterable


def head(title: str) -> str:
    """Return the head of a generated page whose folder's README says how to read it."""
    return f"# {title}\n\nGenerated. [How to read it](README.md).\n"


def table(columns: Iterable[str], rows: Iterable[str]) -> str:
    """Return a table of rows made by `row`; "" where there is none."""
    names = list(columns)
    text = "".join(rows)
    return f"{row(*names)}{'|'.join(['---'] * len(names))}\n{text}" if text else ""


def row(*cells: str) -> str:
    """Return one row; empty cells at its end are left out."""
    return re.sub(r"\| (?=\|)", "|", " |".join(cells)).rstrip(" |") + "\n"
