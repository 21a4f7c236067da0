"""Names to choose from: the error for one that does not exist."""

from collections.abc import Iterable, Iterator
from difflib import get_close_matches

PART_ALIKE = 0.65
"""Share of a part that must be alike: two letters of three."""
SHORTEST_PART = 3
"""Letters of a name that is looked for in parts of others."""


def nearest(name: object, known: Iterable[object]) -> object | None:
    """Return the most similar known name, or one with a word of the same beginning (ins_eds for inz); None: there is
    none."""
    wanted, there = str(name).lower(), {str(item).lower(): item for item in known}
    near = get_close_matches(wanted, there, n=1)
    if near:
        return there[near[0]]
    parts: dict[str, object] = {}
    for text, item in there.items():
        for part in _parts(text, wanted):
            parts.setdefault(part, item)
    near = get_close_matches(wanted, parts, n=1, cutoff=PART_ALIKE) if len(wanted) >= SHORTEST_PART else []
    return parts[near[0]] if near else None


def _parts(text: str, wanted: str) -> Iterator[str]:
    """Yield what begins with a word, as long as `wanted` and with its first letter."""
    for at in range(len(text)):
        if text[at] == wanted[:1] and (at == 0 or text[at - 1] == "_"):
            yield text[at : at + len(wanted)]


def meant(name: object, known: Iterable[object]) -> str:
    """Return " (did you mean port)" with the known name that is nearest, "" when none is near."""
    near = nearest(name, known)
    return "" if near is None else f" (did you mean {near})"


def none_of(name: object, known: Iterable[object]) -> str:
    """Return "'prot' is not one of port, baud", with what was meant where that can be guessed."""
    there = list(known)
    names = [repr(item) if "," in str(item) else str(item) for item in there]
    return f"{name!r} is not one of {', '.join(names)}{meant(name, there)}"
