"""Types as a reader of the pages would say them."""

from types import UnionType
from typing import Annotated, Literal, Union, get_args, get_origin

from ods.base.settings import Slider

GENERATED = "Generated from the types by `make docs`; do not edit."


def type_name(hint: object) -> str:
    """Return a type as a reader of the docs would say it, ranges included."""
    if get_origin(hint) is Annotated:
        kind, *extras = get_args(hint)
        return " ".join([type_name(kind), *(bound for extra in extras for bound in _bounds(extra))])
    if get_origin(hint) is Literal:
        return " or ".join(f"`{value}`" for value in get_args(hint))
    if get_origin(hint) in (UnionType, Union):
        return " or ".join(type_name(item) for item in get_args(hint))
    if get_args(hint):
        names = [type_name(item) for item in get_args(hint)]
        if len(names) > 1 and len(set(names)) == 1:  # a vector
            return f"{len(names)} x {names[0]}"
        inside = ", ".join(names)
        return f"{getattr(get_origin(hint), '__name__', '')}[{inside}]"
    return "none" if hint is type(None) else "..." if hint is ... else getattr(hint, "__name__", str(hint))


def _bounds(meta: object) -> list[str]:
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    values = {sign: getattr(meta, name, None) for name, sign in signs.items()}
    extra = getattr(meta, "extra", None) or {}
    odd = ["odd"] if extra.get("odd") else []
    bounds = [f"{sign} {value:g}" for sign, value in values.items() if value is not None]
    return [*odd, *bounds, *([_shown(extra["slider"])] if "slider" in extra else [])]


def _shown(slider: Slider) -> str:
    ends = f"{slider.low:g} to {slider.high:g}"
    return f"({', '.join(filter(None, (ends, 'logarithmic' if slider.log else '', slider.unit)))})"
