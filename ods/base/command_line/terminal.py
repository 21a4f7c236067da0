"""Output for terminals only: colours, and a line that is written over."""

import os
import sys
from typing import TextIO

_CODES = {"green": "32", "yellow": "33", "red": "1;31"}


def coloured(text: str, colour: str, stream: TextIO | None = None) -> str:
    """Return `text` in `colour` (green, yellow, red) if `stream`, by default standard output, is a terminal.

    It stays as it is where the environment has NO_COLOR (no-color.org).
    """
    shown: TextIO | None = stream or sys.stdout  # none of them where it was closed: `ods doctor >&-`
    if "NO_COLOR" in os.environ or shown is None or not shown.isatty():
        return text
    return f"\x1b[{_CODES[colour]}m{text}\x1b[0m"


class StatusLine:
    """One line on standard error that each `show` replaces and `clear` removes; silent where that is no terminal."""

    def show(self, text: str) -> None:
        """Replace the line, truncated to the terminal's width."""
        if sys.stderr is not None and sys.stderr.isatty():
            width = os.get_terminal_size(sys.stderr.fileno()).columns
            sys.stderr.write(f"\r{text[: width - 1]}\x1b[K")
            sys.stderr.flush()

    def clear(self) -> None:
        """Remove the line."""
        self.show("")
