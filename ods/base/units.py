"""The unit of a number in typed settings: of its key's ending, else of what is said about its type."""

import re
from collections.abc import Iterator

from msgspec import inspect

from ods.base.allowed_names import types_at

UNITS = {
    "_per_count": "", "_m_s": "m/s", "_deg_s": "degrees/s",  # before those that they end with
    "_m_s2": "m/s^2", "_deg_s2": "degrees/s^2", "position_ned": "metres", "velocity_ned": "m/s",
    "_m": "metres", "_s": "seconds", "_ms": "milliseconds", "_min": "minutes", "_deg": "degrees", "_rad": "radians",
    "_hz": "Hz", "_db": "dB", "_px": "pixels", "_percent": "percent", "_ppt": "parts per thousand",
    "_bytes": "bytes", "_mb": "megabytes", "_mbps": "Mbit/s", "_beams": "beams", "_cells": "cells",
    "_wavelengths": "wavelengths",
}  # fmt: skip
"""By the ending of a key."""
WORDS = {"m": "metres", "s": "seconds", "ms": "milliseconds", "deg": "degrees", "rad": "radians"}
"""Of units that are said otherwise."""


def unit_of(kind: type, path: str) -> str:
    """Return the unit, in words, of the number at `path` of a `kind`; "" where it has none or is no number."""
    types = types_at(kind, path)
    if not any(_is_number(place) for place in types):
        return ""
    unit = next(filter(None, (*map(_said, types), _of_key(path))), "")
    return WORDS.get(unit, unit)


def _of_key(path: str) -> str:
    key = re.sub(r"(\[[^\]]*\])+$", "", path).rpartition(".")[2]
    return next((unit for ending, unit in UNITS.items() if key.endswith(ending)), "")


def _said(place: inspect.Type) -> str:
    """Return the unit of a slider, or one by itself, beside a type."""
    for part in _parts(place):
        extra = (part.extra or {}) if isinstance(part, inspect.Metadata) else {}
        unit = extra.get("unit") or (extra["slider"].unit if "slider" in extra else "")
        if unit:
            return str(unit)
    return ""


def _is_number(place: inspect.Type) -> bool:
    """Return whether it is one, or several in a list."""
    return any(isinstance(part, inspect.IntType | inspect.FloatType) for part in _parts(place))


def _parts(place: inspect.Type) -> Iterator[inspect.Type]:
    """Yield a type and the ones that it is made of, but for fields of tables."""
    yield place
    if isinstance(place, inspect.Metadata):
        yield from _parts(place.type)
    elif isinstance(place, inspect.UnionType):
        for one in place.types:
            yield from _parts(one)
    elif isinstance(place, inspect.TupleType):
        for one in place.item_types:
            yield from _parts(one)
    elif isinstance(place, inspect.ListType | inspect.VarTupleType):
        yield from _parts(place.item_type)
