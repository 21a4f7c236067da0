"""Types, defaults and limits as text for the pages."""

import inspect
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import msgspec

from ods.base.settings import Settings, Slider

WORDS = {
    str: "text",
    int: "int",
    float: "float",
    bool: "bool",
    bytes: "bytes",
    dict: "table",
    Path: "path",
}
"""Of plain types."""
NONE = type(None)
LONGEST_DEFAULT = 60
ENDLESS = (86_400.0, 2**53, 2**62)
"""Upper bounds that only keep numbers computable: of a duration, of integers in messages."""


def type_name(hint: object) -> str:
    """Return a type without its bounds: `float`, `float[3]`, `int[]`, `Site?`."""
    if get_origin(hint) is Annotated:
        return type_name(get_args(hint)[0])
    if get_origin(hint) is Literal:
        return "text" if all(isinstance(value, str) for value in get_args(hint)) else "int"
    if get_origin(hint) in (UnionType, Union):
        return _either(item for item in get_args(hint) if item is not NONE) + "?" * (NONE in get_args(hint))
    if get_origin(hint) is dict:
        return f"map of {type_name(get_args(hint)[1])}"
    if get_args(hint):
        items = [item for item in get_args(hint) if item is not ...]
        vector = len(items) > 1 and len({type_name(item) for item in items}) == 1
        return f"{_either(items)}[{len(items) if vector else ''}]"
    if not isinstance(hint, type):
        return str(hint)
    if issubclass(hint, Settings):
        return "table"
    return WORDS.get(hint, hint.__name__)


def _either(hints: Iterable[object]) -> str:
    return "/".join(dict.fromkeys(map(type_name, hints)))


def choices(hint: object) -> list[object]:
    """Return the values that a type allows one by one."""
    return [value for part in _parts(hint) if get_origin(part) is Literal for value in get_args(part)]


def limits(hint: object) -> str:
    """Return the range of a number, the usual one in brackets where it has a slider; "" where neither bounds both."""
    metas = [extra for part in _parts(hint) if get_origin(part) is Annotated for extra in get_args(part)[1:]]
    slider = next((meta.extra["slider"] for meta in metas if meta.extra and "slider" in meta.extra), None)
    odd = "odd " if any((meta.extra or {}).get("odd") for meta in metas) else ""
    if isinstance(slider, Slider):
        return f"({odd}{slider.low:g}..{slider.high:g})"
    low = next((text for meta in metas if (text := _bound(meta.ge, meta.gt, ">"))), "")
    high = next((text for meta in metas if (text := _bound(meta.le, meta.lt, "<"))), "")
    return f"{odd}{low}..{high}" if low and high else ""


def _bound(included: float | None, excluded: float | None, sign: str) -> str:
    """Return a bound as text; "" where there is none, or one that only keeps numbers computable."""
    if included is not None:
        return "" if included in ENDLESS else f"{included:.10g}"
    return "" if excluded is None else f"{sign}{excluded:.10g}"


def default_of(field: msgspec.structs.FieldInfo, hint: object) -> str:
    """Return what a key has if it is left out, or whether it must be given and as what."""
    if inspect.isfunction(field.default_factory):  # it depends on the machine
        return type_name(hint)
    if field.required:
        return "required" if choices(hint) or type_name(hint) == "float" else f"required {type_name(hint)}"
    value = field.default if field.default is not msgspec.NODEFAULT else field.default_factory()
    if value is None:
        return type_name(hint).removesuffix("?")
    shown = _toml(value)
    return f"`{shown}`" if shown and len(shown) < LONGEST_DEFAULT else type_name(hint)


def _toml(value: Any) -> str:
    """Return a value as TOML has it, floats short; "" for a table."""
    if isinstance(value, bool):
        return f"{value}".lower()
    if isinstance(value, float):
        return f"{value:g}" if abs(value) >= 1e6 or 0 < abs(value) < 1e-4 else f"{value}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return "" if isinstance(value, dict) else f'"{value}"' if isinstance(value, str) else f"{value}"


def _parts(hint: object) -> Iterator[object]:
    """Yield a type and all that it is made of."""
    yield hint
    for item in get_args(hint) if get_origin(hint) is not Literal else ():
        yield from _parts(item)
