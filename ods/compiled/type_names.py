"""Names of argument types: the same for a value, which is all that there is without numba, and for its numba type."""

from collections.abc import Callable, Iterable
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

_SHAPE_OF_ARRAY = attrgetter("dtype", "ndim", "flags.num")
_INT64 = range(-(2**63), 2**63)


class _ShapeOf(dict[type, Callable[[Any], Any]]):
    """How the shape of a value is told, by its class: one look-up, as records of numbers and arrays are called with."""

    def __missing__(self, kind: type) -> Callable[[Any], Any]:
        how: Callable[[Any], Any] = type
        if issubclass(kind, np.ndarray):
            how = _SHAPE_OF_ARRAY
        elif issubclass(kind, tuple):
            how = partial(_shape_of_tuple, kind)
        self[kind] = how
        return how


_SHAPE_OF = _ShapeOf()


def shape_of_values(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return what decides the values' types, quicker than their names; several shapes may have one name."""
    return tuple([_SHAPE_OF[type(value)](value) for value in values])


def _shape_of_tuple(kind: type, values: tuple[Any, ...]) -> tuple[Any, ...]:
    return kind, *[_SHAPE_OF[type(value)](value) for value in values]


def name_of_value(value: Any) -> str:
    """Return the name of the type that numba gives `value`; of a kind that no kernel is called with, the class's."""
    if isinstance(value, np.ndarray):
        layout = "C" if value.flags.c_contiguous else "F" if value.flags.f_contiguous else "A"
        return _array(str(value.dtype), value.ndim, layout, value.flags.writeable)
    if isinstance(value, np.generic):
        return str(value.dtype)
    if isinstance(value, tuple):
        return _tuple(type(value), [name_of_value(item) for item in value])
    if type(value) is int:
        return "int64" if value in _INT64 else "uint64"
    return {float: "float64", bool: "bool", type(None): "none"}.get(type(value), str(type(value)))


def name_of_type(kind: Any) -> str:
    """Return the name of a type of numba."""
    from numba.core import types
    from numba.np.numpy_support import as_dtype

    if isinstance(kind, types.Array):
        dtype = as_dtype(kind.dtype) if isinstance(kind.dtype, types.Record) else kind.dtype
        return _array(str(dtype), kind.ndim, kind.layout, kind.mutable)
    if isinstance(kind, types.BaseTuple):
        items: Any = kind
        return _tuple(getattr(kind, "instance_class", tuple), [name_of_type(item) for item in items])
    return str(kind)


def _array(dtype: str, dimensions: int, layout: str, writeable: bool) -> str:
    return f"{'' if writeable else 'readonly '}{dtype}[{dimensions}{layout}]"


def _tuple(kind: type, items: Iterable[str]) -> str:
    return f"{kind.__module__}.{kind.__qualname__}({', '.join(items)})"
