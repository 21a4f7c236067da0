"""Names to choose from: what the user is told of one that is not there."""

from collections.abc import Iterable
from difflib import get_close_matches

BEGINNING = 2
"""Letters."""


def meant(name: object, known: Iterable[object]) -> str:
    """Return " (did you mean port)" with the known name that is nearest, "" when none is near.

    One that begins alike is near, too: `inz` may have become `ins_eds`.
    """
    there, told = {str(item).lower(): item for item in known}, str(name).lower()
    alike = [item for item in there if item[:BEGINNING] == told[:BEGINNING]]
    near = get_close_matches(told, there, n=1) or get_close_matches(told, alike, n=1, cutoff=0.0)
    return f" (did you mean {there[near[0]]})" if near else ""


def none_of(name: object, known: Iterable[object]) -> str:
    """Return "'prot' is none of port, baud", with what was meant where that can be guessed."""
    there = list(known)
    names = [repr(item) if "," in str(item) else str(item) for item in there]
    return f"{name!r} is none of {', '.join(names)}{meant(name, there)}"
