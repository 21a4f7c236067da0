"""ROS's message types as cyclonedds wants them, made of rosbags' definitions; samples carry CDR that rosbags made.

CDR by cyclonedds's Python types takes 200 times longer for images.
"""

from typing import Any

from cyclonedds.idl import IdlStruct, make_idl_struct, types
from rosbags.interfaces import Nodetype
from rosbags.typesys.store import Typestore

NUMBERS = {
    "bool": bool, "byte": types.uint8, "char": types.uint8, "uint8": types.uint8, "int8": types.int8,
    "uint16": types.uint16, "int16": types.int16, "uint32": types.uint32, "int32": types.int32,
    "uint64": types.uint64, "int64": types.int64, "float32": types.float32, "float64": types.float64, "string": str,
}  # fmt: skip


class DdsTypes:
    """Types by their names in ROS, made once each."""

    def __init__(self, store: Typestore) -> None:
        self._store = store
        self._made: dict[str, type[IdlStruct]] = {}

    def of(self, kind: str) -> type[IdlStruct]:
        """Return a type whose samples are made of CDR: `of("std_msgs/msg/String")(cdr)`."""

        def initialise(self: Any, cdr: bytes) -> None:
            self.cdr = cdr

        def serialize(self: Any, *_: Any, **__: Any) -> bytes:
            return bytes(self.cdr)

        made = self._struct(kind)
        made.__init__ = initialise
        made.serialize = serialize
        return made

    def _struct(self, kind: str) -> type[IdlStruct]:
        if kind not in self._made:
            _, fields = self._store.fielddefs[kind]
            package, _, name = kind.partition("/msg/")
            self._made[kind] = make_idl_struct(
                f"{name}_",
                f"{package}.msg.dds_.{name}_",
                {field: self._field(what) for field, what in fields},
                dataclassify=False,
            )
        return self._made[kind]

    def _field(self, what: Any) -> Any:
        node, detail = what
        if node == Nodetype.BASE:
            return NUMBERS[detail[0]]
        if node == Nodetype.NAME:
            return self._struct(detail)
        inner, count = detail
        return types.array[self._field(inner), count] if node == Nodetype.ARRAY else types.sequence[self._field(inner)]


def type_hash(store: Typestore, kind: str) -> str:
    """Return the hash of a type, RIHS01 (REP 2016), as nodes since Iron look for it in a publisher's user data."""
    return str(store.hash_rihs01(kind))
