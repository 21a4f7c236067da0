"""Calls of kernels as tests make them, on file: a plug-in of pytest, `-p benchmarks.installation.kernel_calls`.

`ODS_KERNEL_CALLS` names the folder. `calls.bin` has what each call takes, for cross_build.c, which says how;
`made.pickle` has what came of it. Of each kernel the first few calls are kept whose arrays have other sizes.
"""

import os
import pickle
import struct
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ods.compiled import native

CALLS = 4
"""Of a kernel."""
LARGEST = 4_000_000
"""Bytes of one call."""
HEADER, ARGUMENT = struct.Struct("<64sq"), struct.Struct("<q4qqqdqq")


class Made(NamedTuple):
    """What a call returned, and its arrays after it; None: the same array as one before."""

    kernel: str
    returned: float | None
    arrays: list["np.ndarray[Any, Any] | None"]


_made: list[Made] = []
_calls: list[bytes] = []
_seen: dict[str, set[Any]] = defaultdict(set)


def pytest_configure() -> None:
    """Let all kernels be called by way of here."""
    for name in dir(native):
        if not name.startswith("_"):
            setattr(native, name, _noted(name, getattr(native, name)))


def pytest_unconfigure() -> None:
    """Write what was noted."""
    folder = Path(os.environ["ODS_KERNEL_CALLS"])
    (folder / "calls.bin").write_bytes(b"".join(_calls))
    (folder / "made.pickle").write_bytes(pickle.dumps([tuple(made) for made in _made]))


def _noted(name: str, kernel: Callable[..., Any]) -> Callable[..., Any]:
    def call(*arguments: Any) -> Any:
        values = list(_flat(arguments))
        arrays = [value for value in values if isinstance(value, np.ndarray)]
        kind = tuple((array.dtype.str, array.shape) for array in arrays)
        if len(_seen[name]) == CALLS or kind in _seen[name] or sum(array.nbytes for array in arrays) > LARGEST:
            return kernel(*arguments)
        before = _packed(name, values)
        returned = kernel(*arguments)
        _seen[name].add(kind)
        _calls.append(before)
        same = _same(values)
        kept = [
            None if same[k] >= 0 else value.copy() for k, value in enumerate(values) if isinstance(value, np.ndarray)
        ]
        _made.append(Made(name, None if returned is None else float(returned), kept))
        return returned

    call.__doc__ = kernel.__doc__
    return call


def _flat(arguments: tuple[Any, ...]) -> Iterator[Any]:
    for value in arguments:
        if isinstance(value, tuple):
            yield from _flat(value)
        else:
            yield value


def _same(values: list[Any]) -> list[int]:
    """Return for each value which one before it is the same array, -1 for none."""
    places: dict[tuple[int, int], int] = {}
    same = []
    for k, value in enumerate(values):
        key = (value.ctypes.data, value.nbytes) if isinstance(value, np.ndarray) and value.nbytes else (-k - 1, 0)
        same.append(places.get(key, -1))
        places.setdefault(key, k)
    return same


def _packed(name: str, values: list[Any]) -> bytes:
    parts = [HEADER.pack(name.encode(), len(values))]
    for value, same in zip(values, _same(values), strict=True):
        if isinstance(value, np.ndarray):
            shape = (*value.shape, *[0] * (4 - value.ndim))
            stride = value.shape[-1] if value.ndim > 1 else 1
            code = ord("l" if value.dtype.char == "q" else value.dtype.char)
            data = b"" if same >= 0 else value.tobytes()
            parts += [ARGUMENT.pack(code, *shape, stride, 0, 0.0, same, len(data)), data]
        else:
            whole = int(value) if np.isfinite(value) else 0
            parts.append(ARGUMENT.pack(0, 0, 0, 0, 0, 0, whole, float(value), -1, 0))
    return b"".join(parts)
