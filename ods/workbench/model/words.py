"""What settings are called on the page: their names in words, and the unit that a name ends with."""

from typing import NamedTuple

UNITS = {
    "m": "m", "s": "s", "ms": "ms", "deg": "°", "rad": "rad", "db": "dB", "hz": "Hz", "mps": "m/s",
    "counts": "counts", "percent": "%",
}  # fmt: skip
"""By the last word of a name."""
WORDS = {"min": "smallest", "max": "largest", "rms": "rms", "pfa": "false alarms", "cd": "Cd", "cs": "Cs"}
NAMES = {
    "high": "high level", "low": "low level", "rate": "false-alarm rate", "min_cells": "fewest cells",
    "max_cells": "most cells", "min_range_m": "nearest range", "train": "surroundings", "taps": "filter length",
    "cutoff": "cut-off", "beam_cutoff": "cut-off over beams", "position_ned": "place", "velocity_ned": "velocity",
    "split_db": "split depth", "life": "lives", "echo": "echoes", "stand_by_s": "stand-by",
}  # fmt: skip
"""Names that their keys do not show."""


class Called(NamedTuple):
    """A setting's name in words, and its unit; empty: it has none, or the name does not show it."""

    name: str
    unit: str


def called(field: str) -> Called:
    """Return what a field is called: "max_extent_m" is the "largest extent" in "m"."""
    words = field.split("_")
    unit = UNITS.get(words[-1], "") if len(words) > 1 else ""
    if field in NAMES:
        return Called(NAMES[field], unit)
    return Called(" ".join(WORDS.get(word, word) for word in (words[:-1] if unit else words)), unit)


def sentence(text: str) -> str:
    """Return the first sentence of a docstring, as one line."""
    line = " ".join(text.split())
    end = line.find(". ")
    return line if end < 0 else line[: end + 1]
