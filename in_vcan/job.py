"""What is to be run, and how a way to run it says that it cannot."""

import sys
from dataclasses import dataclass

OUT_OF_TIME = 124
"""Exit status, as of timeout(1)."""
NO_WAY = 125
"""Exit status: there is no way to get a vcan here."""


@dataclass(frozen=True)
class Job:
    """A command, to be run in the caller's folder and environment."""

    command: list[str]
    timeout_s: float | None


class NotHereError(Exception):
    """This way is not possible on this machine; the text says what is missing. Nothing of the command has run."""


def say(text: str) -> None:
    """Tell the user, beside the command's own output."""
    print(f"in_vcan: {text}", file=sys.stderr, flush=True)
