"""Units as people write them into DBC files."""

import math

from ods.base.choices import meant

MEASURES: dict[str, dict[str, float]] = {
    "length": {"m": 1.0, "meter": 1.0, "metre": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048},
    "angle": {
        "rad": 1.0, "radian": 1.0, "mrad": 1e-3, "deg": math.pi / 180.0, "degree": math.pi / 180.0, "°": math.pi / 180.0
    },
    "speed": {
        "m/s": 1.0, "m.s-1": 1.0, "m*s-1": 1.0, "m*s^-1": 1.0, "ms-1": 1.0, "ms^-1": 1.0, "mps": 1.0,
        "m/sec": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "km/h": 1.0 / 3.6, "kph": 1.0 / 3.6,
        "kn": 1852.0 / 3600.0, "kt": 1852.0 / 3600.0, "knot": 1852.0 / 3600.0,
    },
    "time": {
        "s": 1.0, "sec": 1.0, "second": 1.0, "ms": 1e-3, "msec": 1e-3, "us": 1e-6, "usec": 1e-6, "ns": 1e-9,
    },
    "a plain number": {"": 1.0, "-": 1.0, "1": 1.0},
}  # fmt: skip
"""Unit texts, as `_plain` has them, by what they measure: each in SI units."""


def conversion(unit: str, wanted: str) -> float:
    """Return how many `wanted` one `unit` is. Raises ValueError when they do not measure the same."""
    measure, units = next((measure, units) for measure, units in MEASURES.items() if wanted in units)
    if _plain(unit) not in units:
        example = f", such as {wanted}" if wanted else ""
        raise ValueError(f"{unit!r} is not a known unit of {measure}{example}{meant(unit, units)}")
    return units[_plain(unit)] / units[wanted]


def _plain(text: str) -> str:
    """Return a unit text without blanks, capitals, plural, and the two micro signs of Unicode."""
    text = "".join(text.split()).lower().replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")
    return text[:-1] if len(text) > 3 and text.endswith("s") and text[-2].isalpha() else text
