"""Contents of the INS's PDOs: its EDS, read once and turned into precompiled decoders."""

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable, datatypes

from ods.nav_bridge.can.frame import MAX_DATA_BYTES
from ods.nav_bridge.canopen.eds import EdsError, number_of, read_dictionary
from ods.nav_bridge.canopen.object_map import SEQUENCE_FIELD, STATUS_FIELD, TIME_FIELD, MappedObject, ObjectAddress

STRUCT_CODES: dict[int, str] = {
    datatypes.INTEGER8: "b",
    datatypes.INTEGER16: "h",
    datatypes.INTEGER32: "i",
    datatypes.INTEGER64: "q",
    datatypes.UNSIGNED8: "B",
    datatypes.UNSIGNED16: "H",
    datatypes.UNSIGNED32: "I",
    datatypes.UNSIGNED64: "Q",
    datatypes.REAL32: "f",
    datatypes.REAL64: "d",
}
UNSIGNED_CODES = frozenset("BHIQ")
ODD_BYTES: dict[int, tuple[int, bool]] = {
    datatypes.INTEGER24: (3, True),
    datatypes.INTEGER40: (5, True),
    datatypes.INTEGER48: (6, True),
    datatypes.INTEGER56: (7, True),
    datatypes.UNSIGNED24: (3, False),
    datatypes.UNSIGNED40: (5, False),
    datatypes.UNSIGNED48: (6, False),
    datatypes.UNSIGNED56: (7, False),
}
"""Bytes of the numbers that `struct` does not know, and whether they have a sign."""
TIME_OF_DAY_BITS = 48
FIRST_TPDO, FIRST_MAPPING, TPDO_COUNT = 0x1800, 0x1A00, 512
NOT_VALID = 1 << 31
EXTENDED_ID = 1 << 29
COB_ID_MASK = 0x7FF
MAX_MAPPED = 64
RESTRICTED = (
    (0x000, 0x07F), (0x101, 0x180), (0x581, 0x5FF), (0x601, 0x67F), (0x6E0, 0x6FF), (0x701, 0x7FF),
)  # fmt: skip
"""COB-IDs that are no PDO's (CiA 301), from and to."""


@dataclass(frozen=True)
class PdoLayout:
    """How to decode one PDO of the pose set."""

    place: int
    """Position in the set, from 0: the order of sending."""
    cob_id: int
    packed: struct.Struct
    fields: tuple[str, ...]
    factors: tuple[float, ...]
    odd: tuple[tuple[int, bool], ...] = ()
    """Of the fields that are bytes, in `ODD_BYTES`: position, and whether they have a sign."""

    @property
    def restricted(self) -> bool:
        """Its COB-ID is not one that a PDO may have."""
        return any(first <= self.cob_id <= last for first, last in RESTRICTED)

    @property
    def size(self) -> int:
        """Mapped length in bytes."""
        return self.packed.size

    def decode(self, data: bytes) -> dict[str, float]:
        """Return the fields in their units; bytes beyond the mapped ones are ignored (CiA 301).

        The time of day is `time_ms` (raw, with its reserved bits) and `time_days`.
        """
        raw = self.packed.unpack_from(data)
        if self.odd:
            numbers = list(raw)
            for position, signed in self.odd:
                numbers[position] = int.from_bytes(raw[position], "little", signed=signed)
            raw = tuple(numbers)
        return {name: value * factor for name, value, factor in zip(self.fields, raw, self.factors, strict=True)}


@dataclass(frozen=True)
class PdoSet:
    """The PDOs that together carry one pose."""

    layouts: tuple[PdoLayout, ...]
    """In the order of sending."""
    sequence_modulus: int | None
    """The sequence number, carried by the first PDO, runs from 0 to this, exclusive. None: there is none."""
    status_bits: int
    """Of the status; 0: there is none."""

    @property
    def fields(self) -> frozenset[str]:
        """All values of one epoch."""
        return frozenset(name for layout in self.layouts for name in layout.fields)


class _Entry(NamedTuple):
    """One mapped object: its struct format, and what it is."""

    code: str
    fields: tuple[str, ...] = ()
    factors: tuple[float, ...] = ()
    signed: bool | None = None
    """Of a number of an odd count of bytes."""


def load_pdo_set(eds: Path, node_id: int, objects: Mapping[ObjectAddress, MappedObject]) -> PdoSet:
    """Return the INS's valid transmit PDOs that carry one of `objects`. Raises EdsError."""
    dictionary = read_dictionary(eds, node_id, "nav.canopen.ins_eds")
    carried: set[ObjectAddress] = set()
    try:
        layouts = tuple(_layouts(dictionary, objects, carried))
        sequence_bits, status_bits = (_bits(dictionary, objects, name) for name in (SEQUENCE_FIELD, STATUS_FIELD))
    except ValueError as error:
        raise EdsError(f"{eds}: {error}") from error
    missing = [
        f"{mapped.name} ({mapped.field})"
        for where, mapped in objects.items()
        if where not in carried and not mapped.is_optional
    ]
    if missing or not layouts:
        raise EdsError(f"{eds}: no transmit PDO carries {', '.join(missing) or 'a pose field'}")
    if len({layout.cob_id for layout in layouts}) < len(layouts):
        raise EdsError(f"{eds}: two transmit PDOs have the same COB-ID")
    if sequence_bits and SEQUENCE_FIELD not in layouts[0].fields:
        raise EdsError(f"{eds}: the first PDO of the set, 0x{layouts[0].cob_id:X}, must carry the sequence number")
    return PdoSet(layouts, 1 << sequence_bits if sequence_bits else None, status_bits)


def _layouts(
    dictionary: ObjectDictionary, objects: Mapping[ObjectAddress, MappedObject], carried: set[ObjectAddress]
) -> Iterator[PdoLayout]:
    place = 0
    for number in range(TPDO_COUNT):
        if FIRST_TPDO + number not in dictionary:
            continue
        if not _carries_any(dictionary, FIRST_MAPPING + number, objects):
            continue  # whatever its entries say
        cob_id = number_of(dictionary, FIRST_TPDO + number, 1)
        if cob_id & (NOT_VALID | EXTENDED_ID):
            continue
        entries = list(_entries(dictionary, FIRST_MAPPING + number, objects, carried))
        fields = tuple(name for entry in entries for name in entry.fields)
        packed = struct.Struct("<" + "".join(entry.code for entry in entries))
        if packed.size > MAX_DATA_BYTES:
            raise ValueError(f"TPDO {number + 1} maps {packed.size} bytes, more than a CAN frame holds")
        factors = tuple(factor for entry in entries for factor in entry.factors)
        signs = [entry.signed for entry in entries for _ in entry.fields]
        odd = tuple((position, signed) for position, signed in enumerate(signs) if signed is not None)
        yield PdoLayout(place, cob_id & COB_ID_MASK, packed, fields, factors, odd)
        place += 1


def _carries_any(dictionary: ObjectDictionary, index: int, objects: Mapping[ObjectAddress, MappedObject]) -> bool:
    """Return whether a mapping record, as far as it counts and can be read, maps one of `objects`."""
    try:
        count = number_of(dictionary, index, 0)
    except ValueError:
        count = MAX_MAPPED
    for subindex in range(1, min(count, MAX_MAPPED) + 1):
        try:
            mapped = number_of(dictionary, index, subindex)
        except ValueError:
            continue
        if (mapped >> 16, mapped >> 8 & 0xFF) in objects:
            return True
    return False


def _entries(
    dictionary: ObjectDictionary, index: int, objects: Mapping[ObjectAddress, MappedObject], carried: set[ObjectAddress]
) -> Iterator[_Entry]:
    """Yield one mapping record; what is no pose field is skipped, be it single bits."""
    skipped = 0
    for subindex in range(1, number_of(dictionary, index, 0) + 1):
        mapped = number_of(dictionary, index, subindex)
        where, bits = (mapped >> 16, mapped >> 8 & 0xFF), mapped & 0xFF
        source = objects.get(where)
        if source is None:
            skipped += bits
            continue
        if skipped % 8:
            raise ValueError(f"object {source.name} is mapped behind {skipped} bits, not whole bytes")
        yield _Entry(f"{skipped // 8}x")
        skipped = 0
        carried.add(where)
        yield _entry(dictionary.get_variable(*where), source, bits)
    yield _Entry(f"{-(-skipped // 8)}x")


def _entry(variable: ODVariable | None, mapped: MappedObject, bits: int) -> _Entry:
    if mapped.field == TIME_FIELD:
        if bits != TIME_OF_DAY_BITS:
            raise ValueError(f"the time of day is mapped with {bits} bits instead of {TIME_OF_DAY_BITS}")
        return _Entry("IH", ("time_ms", "time_days"), (1, 1))
    kind = (variable.data_type or 0) if variable is not None else 0
    size, signed = ODD_BYTES.get(kind, (0, None))
    code = f"{size}s" if size else STRUCT_CODES.get(kind)
    if variable is None or code is None or struct.calcsize(code) * 8 != bits:
        raise ValueError(f"object {mapped.name} is missing, or its type does not fit {bits} bits")
    if mapped.field not in (SEQUENCE_FIELD, STATUS_FIELD):
        return _Entry(code, (mapped.field,), (variable.factor if mapped.factor is None else mapped.factor,), signed)
    if code not in UNSIGNED_CODES:
        raise ValueError(f"object {mapped.name} ({mapped.field}) is not an unsigned number")
    return _Entry(code, (mapped.field,), (1,))


def _bits(dictionary: ObjectDictionary, objects: Mapping[ObjectAddress, MappedObject], field: str) -> int:
    """Return the width of what carries a field, 0 where nothing does. Raises ValueError."""
    variables = [dictionary.get_variable(*where) for where, mapped in objects.items() if mapped.field == field]
    widths = {len(variable) for variable in variables if variable is not None}
    if len(widths) > 1:
        raise ValueError(f"the objects that carry the {field} have different types")
    return widths.pop() if widths else 0
