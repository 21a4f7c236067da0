"""What may stand at a place of typed settings: the keys of a table, the values of a choice."""

import re
from collections.abc import Iterator
from typing import Any

from msgspec import inspect


def allowed_names(kind: type, path: str) -> list[Any]:
    """Return the keys that the table at `path` has in a `kind`, or the values that a choice there may have.

    path: as msgspec writes it, without the `$`: "nav.dbc.valid[0].says", with "[...]" for any key of a dict.
    """
    places: list[inspect.Type] = list(_plain(inspect.type_info(kind)))
    for name, index in re.findall(r"([^.\[\]]+)|\[([^\]]*)\]", path):
        places = [inner for place in places for inner in _inside(place, name or f"[{index}]")]
    return [name for place in places for name in _names(place)]


def _inside(place: inspect.Type, step: str) -> Iterator[inspect.Type]:
    """Yield what may stand one step further in."""
    if isinstance(place, inspect.StructType):
        for field in place.fields:
            if field.encode_name == step:
                yield from _plain(field.type)
    elif isinstance(place, inspect.ListType | inspect.VarTupleType):
        yield from _plain(place.item_type)
    elif isinstance(place, inspect.DictType):
        yield from _plain(place.value_type)


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
    return list(place.values) if isinstance(place, inspect.LiteralType) else []
