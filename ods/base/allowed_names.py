"""Allowed names at a place of typed settings: the keys of a table, the values of a choice."""

import re
from collections.abc import Iterator
from typing import Any

from msgspec import inspect


def allowed_names(kind: type, path: str) -> list[Any]:
    """Return the keys that the table at `path` has in a `kind`, or the values that a choice there may have.

    path: as msgspec writes it, without the `$`: "nav.dbc.valid[0].says", with "[...]" for any key of a dict.
    """
    return [name for place in types_at(kind, path) for plain in _plain(place) for name in _names(plain)]


def types_at(kind: type, path: str) -> list[inspect.Type]:
    """Return what may stand at `path`, with what is said about it."""
    places = [inspect.type_info(kind)]
    for name, index in re.findall(r"([^.\[\]]+)|\[([^\]]*)\]", path):
        step = name or f"[{index}]"
        places = [inner for place in places for plain in _plain(place) for inner in _inside(plain, step)]
    return places


def _inside(place: inspect.Type, step: str) -> Iterator[inspect.Type]:
    """Yield what may stand one step further in."""
    if isinstance(place, inspect.StructType):
        yield from (field.type for field in place.fields if field.encode_name == step)
    elif isinstance(place, inspect.ListType | inspect.VarTupleType):
        yield place.item_type
    elif isinstance(place, inspect.TupleType):
        yield from place.item_types
    elif isinstance(place, inspect.DictType):
        yield place.value_type


def _plain(place: inspect.Type) -> Iterator[inspect.Type]:
    """Yield the alternatives of a type, without what is said about them."""
    if isinstance(place, inspect.Metadata):
        yield from _plain(place.type)
    elif isinstance(place, inspect.UnionType):
        for one in place.types:
            yield from _plain(one)
    else:
        yield place


def _names(place: inspect.Type) -> list[Any]:
    if isinstance(place, inspect.StructType):
        return [field.encode_name for field in place.fields]
    names = place.key_type if isinstance(place, inspect.DictType) else place
    return list(names.values) if isinstance(names, inspect.LiteralType) else []
