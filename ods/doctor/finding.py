"""One line of the doctor's report."""

from typing import Literal, NamedTuple


class Finding(NamedTuple):
    """A finding; "wrong" makes the exit code 1."""

    level: Literal["good", "note", "wrong"]
    subject: str
    text: str
