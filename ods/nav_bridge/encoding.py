"""Text files of other makers, whose encoding nobody tells."""

from pathlib import Path

from ods.base.files.in_file import content_of


def read_text(file: Path, encoding: str) -> str:
    """Return the text of a file in UTF-8, with a mark of it or without, or else in `encoding`. Raises OSError."""
    raw = content_of(file)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode(encoding, errors="replace")
