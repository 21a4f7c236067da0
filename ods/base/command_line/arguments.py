"""Types of arguments that several commands take."""

import argparse
import math
import re
from collections.abc import Callable
from typing import NamedTuple

_PART = re.compile(r"(?P<one>-?\d+)|(?P<first>-?\d*):(?P<stop>-?\d*)(:(?P<step>-?\d*))?")


class Choice(NamedTuple):
    """A selection of items counted from 0, in the notation of Python's slices."""

    text: str
    parts: tuple[int | slice, ...]

    def of(self, count: int) -> list[int]:
        """Return the places of those chosen among `count`, each once, in rising order.

        Raises ValueError, one line, when there are none, or not the one that is named.
        """
        places = range(count)
        chosen: set[int] = set()
        for part in self.parts:
            if isinstance(part, slice):
                chosen.update(places[part])
            elif -count <= part < count:
                chosen.add(places[part])
            else:
                raise ValueError(f"{self.text}: there is no {part}, {_those(count)}")
        if not chosen:
            raise ValueError(f"{self.text} selects none: {_those(count)}")
        return sorted(chosen)


def _those(count: int) -> str:
    return f"there are {count}, 0 to {count - 1}" if count else "there are none"


def choice(text: str) -> Choice:
    """Return what `10:20`, `::5`, `7`, or several of these with commas choose."""
    parts: list[int | slice] = []
    for part in text.split(","):
        found = _PART.fullmatch(part.strip())
        if found is None or (found["step"] or "1").lstrip("-").strip("0") == "":
            raise argparse.ArgumentTypeError(f"{text!r}: {part!r} is neither a number nor a range such as 10:20 or ::5")
        if found["one"]:
            parts.append(int(found["one"]))
        else:
            first, stop, step = (int(found[name]) if found[name] else None for name in ("first", "stop", "step"))
            parts.append(slice(first, stop, step))
    return Choice(text, tuple(parts))


def positive_int(text: str) -> int:
    """Return a whole number above 0."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number above 0")
    return int(text)


def port_number(text: str) -> int:
    """Return the number of a TCP port; 0 stands for any that is free."""
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"{text!r} is not a port: 0 to 65535")
    return int(text)


def number(least: float, most: float, unit: str = "") -> Callable[[str], float]:
    """Return a type of argument: numbers from `least` to `most`, `unit` is the word for what they count."""

    def convert(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{text!r} is not a number{unit and f' of {unit}'}, {least:g} to {most:g}")
        return value

    return convert


def duration_s(text: str) -> float:
    """Return a number of seconds above 0 that every clock can count."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < 1e6:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds above 0")
    return seconds
