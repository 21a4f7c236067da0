"""The wire format of Protocol Buffers, as far as packets need it: the fields of one message. Pure.

Source: protobuf.dev/programming-guides/encoding. Groups, which nothing here has, are no fields.
"""

import struct
from typing import NamedTuple

VARINT, FIXED64, BYTES, FIXED32 = 0, 1, 2, 5
MOST_FIELDS = 256
"""Of a message; no packet has more."""
LONGEST_VARINT = 10
_FIXED = {FIXED64: 8, FIXED32: 4}


class Field(NamedTuple):
    """One field, not yet read as its type."""

    kind: int
    number: int
    """Of a VARINT: its value."""
    data: memoryview
    """Of the others: their bytes."""


class Message:
    """The fields of a message by number; what is absent has its default. Raises ValueError for malformed bytes."""

    def __init__(self, data: bytes | memoryview) -> None:
        self._fields: dict[int, list[Field]] = {}
        view, at, count = memoryview(data), 0, 0
        while at < len(view):
            tag, at = _varint(view, at)
            field, at = _field(view, at, tag & 7)
            self._fields.setdefault(tag >> 3, []).append(field)
            count += 1
            if count > MOST_FIELDS:
                raise ValueError(f"protobuf: more than {MOST_FIELDS} fields")

    def integer(self, number: int) -> int:
        """Return an unsigned integer, 0 when absent."""
        field = self._last(number, VARINT)
        return 0 if field is None else field.number

    def real(self, number: int) -> float:
        """Return a `float`, 0 when absent."""
        field = self._last(number, FIXED32)
        return 0.0 if field is None else float(struct.unpack("<f", field.data)[0])

    def data(self, number: int) -> memoryview:
        """Return the bytes of a text, message or packed numbers; empty when absent."""
        field = self._last(number, BYTES)
        return memoryview(b"") if field is None else field.data

    def _last(self, number: int, kind: int) -> Field | None:
        """Return the last of several, as the wire format has it. Raises ValueError: it is of another type."""
        fields = self._fields.get(number)
        if not fields:
            return None
        if any(field.kind != kind for field in fields):
            raise ValueError(f"protobuf: field {number} is of another type")
        return fields[-1]


def _field(view: memoryview, at: int, kind: int) -> tuple[Field, int]:
    if kind == VARINT:
        number, at = _varint(view, at)
        return Field(kind, number, view[:0]), at
    if kind == BYTES:
        size, at = _varint(view, at)
    elif kind in _FIXED:
        size = _FIXED[kind]
    else:
        raise ValueError(f"protobuf: a field of type {kind}")
    if size > len(view) - at:
        raise ValueError("protobuf: a field is truncated")
    return Field(kind, 0, view[at : at + size]), at + size


def _varint(view: memoryview, at: int) -> tuple[int, int]:
    if at < len(view) and view[at] < 0x80:  # nearly all are of one byte
        return view[at], at + 1
    number = 0
    for place, byte in enumerate(view[at : at + LONGEST_VARINT]):
        number |= (byte & 0x7F) << 7 * place
        if byte < 0x80:
            return number, at + place + 1
    raise ValueError("protobuf: a number is not terminated")
