"""What the INS's PDOs carry: its EDS, read once and turned into precompiled decoders."""

import io
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from canopen import ObjectDictionary, import_od
from canopen.objectdictionary import ODVariable, datatypes

from ods.errors import OdsError

SEQUENCE = 0x2000
POSE_OBJECTS: dict[tuple[int, int], str] = {
    (SEQUENCE, 0): "sequence",
    (0x2001, 0): "status",
    (0x2002, 0): "time_of_day",
    (0x2010, 1): "north",
    (0x2010, 2): "east",
    (0x2010, 3): "down",
    (0x2011, 1): "roll",
    (0x2011, 2): "pitch",
    (0x2011, 3): "yaw",
    (0x2012, 1): "u",
    (0x2012, 2): "v",
    (0x2012, 3): "w",
    (0x2013, 1): "sigma_horizontal",
    (0x2013, 2): "sigma_down",
    (0x2013, 3): "sigma_tilt",
    (0x2013, 4): "sigma_yaw",
}
"""Index and sub-index of each pose field; its unit is the EDS's, after Factor: metres, radians, m/s."""

NEEDED = frozenset(POSE_OBJECTS.values()) - {"time_of_day"}

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
TIME_OF_DAY_BITS = 48
FIRST_TPDO, FIRST_MAPPING, TPDO_COUNT = 0x1800, 0x1A00, 512
NOT_VALID = 1 << 31
EXTENDED = 1 << 29
COB_ID_MASK = 0x7FF
MAX_BYTES = 8


class LayoutError(OdsError):
    """An EDS file cannot be used; the text says which and why."""


@dataclass(frozen=True)
class PdoLayout:
    """How to decode one PDO of the pose set."""

    place: int
    """Position in the set, from 0: the order of sending."""
    cob_id: int
    packed: struct.Struct
    fields: tuple[str, ...]
    factors: tuple[float, ...]

    @property
    def size(self) -> int:
        """Mapped length in bytes."""
        return self.packed.size

    def decode(self, data: bytes) -> dict[str, float]:
        """Return the fields in the EDS's units; bytes beyond the mapped ones are ignored (CiA 301)."""
        raw = self.packed.unpack_from(data)
        return {name: value * factor for name, value, factor in zip(self.fields, raw, self.factors, strict=True)}


@dataclass(frozen=True)
class PdoSet:
    """The PDOs that together carry one pose."""

    layouts: tuple[PdoLayout, ...]
    """In the order of sending; the first carries the sequence number."""
    sequence_modulus: int
    """The sequence number runs from 0 to this, exclusive."""


def load_pdo_set(eds: Path, node_id: int) -> PdoSet:
    """Return the INS's valid transmit PDOs that carry pose fields. Raises LayoutError."""
    dictionary = read_dictionary(eds, node_id)
    try:
        layouts = tuple(_layouts(dictionary))
    except ValueError as error:
        raise LayoutError(f"{eds}: {error}") from error
    missing = NEEDED - {name for layout in layouts for name in layout.fields}
    if missing:
        raise LayoutError(f"{eds}: no transmit PDO carries {', '.join(sorted(missing))}")
    if len({layout.cob_id for layout in layouts}) < len(layouts):
        raise LayoutError(f"{eds}: two transmit PDOs have the same COB-ID")
    if "sequence" not in layouts[0].fields:
        raise LayoutError(f"{eds}: the first PDO of the set, 0x{layouts[0].cob_id:X}, must carry the sequence number")
    return PdoSet(layouts, 1 << len(dictionary[SEQUENCE]))


def read_dictionary(eds: Path, node_id: int) -> ObjectDictionary:
    """Read an EDS or DCF file, in UTF-8 or Latin-1. Raises LayoutError."""
    try:
        raw = eds.read_bytes()
    except OSError as error:
        raise LayoutError(f"{eds}: {error.strerror}") from error
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    source = io.StringIO(text)
    source.name = str(eds)  # canopen tells the format by the name
    try:
        return import_od(source, node_id)
    except Exception as error:  # canopen lets through whatever a malformed file runs into
        raise LayoutError(f"{eds}: not a usable EDS: {' '.join(repr(error).split())}") from error


def _layouts(dictionary: ObjectDictionary) -> Iterator[PdoLayout]:
    place = 0
    for number in range(TPDO_COUNT):
        if FIRST_TPDO + number not in dictionary:
            continue
        cob_id = _value(dictionary, FIRST_TPDO + number, 1)
        if cob_id & (NOT_VALID | EXTENDED):
            continue
        code, fields, factors = _mapping(dictionary, FIRST_MAPPING + number)
        if not fields:
            continue
        packed = struct.Struct(code)
        if packed.size > MAX_BYTES:
            raise ValueError(f"TPDO {number + 1} maps {packed.size} bytes, more than a CAN frame holds")
        yield PdoLayout(place, cob_id & COB_ID_MASK, packed, tuple(fields), tuple(factors))
        place += 1


def _mapping(dictionary: ObjectDictionary, index: int) -> tuple[str, list[str], list[float]]:
    """Return struct format, field names and factors of one mapping record; what is not a pose field is skipped."""
    code = "<"
    fields: list[str] = []
    factors: list[float] = []
    for entry in range(1, _value(dictionary, index, 0) + 1):
        mapped = _value(dictionary, index, entry)
        where, bits = (mapped >> 16, mapped >> 8 & 0xFF), mapped & 0xFF
        name = POSE_OBJECTS.get(where)
        if bits % 8:
            raise ValueError(f"object 0x{where[0]:X}:{where[1]:X} is mapped with {bits} bits, not whole bytes")
        if name is None:
            code += f"{bits // 8}x"
        elif name == "time_of_day":
            code += _time_of_day(bits)
            fields += ["time_ms", "time_days"]
            factors += [1, 1]
        else:
            variable = dictionary.get_variable(*where)
            code += _struct_code(variable, where, bits)
            fields.append(name)
            factors.append(variable.factor if variable is not None else 1)
    return code, fields, factors


def _time_of_day(bits: int) -> str:
    if bits != TIME_OF_DAY_BITS:
        raise ValueError(f"the time of day is mapped with {bits} bits instead of {TIME_OF_DAY_BITS}")
    return "IH"


def _struct_code(variable: ODVariable | None, where: tuple[int, int], bits: int) -> str:
    code = STRUCT_CODES.get(variable.data_type or 0) if variable is not None else None
    if code is None or struct.calcsize(code) * 8 != bits:
        raise ValueError(f"object 0x{where[0]:X}:{where[1]:X} is missing, or its type does not fit {bits} bits")
    return code


def _value(dictionary: ObjectDictionary, index: int, subindex: int) -> int:
    variable = dictionary.get_variable(index, subindex)
    if variable is None:
        raise ValueError(f"object 0x{index:X}:{subindex:X} is missing")
    value = variable.default if variable.value is None else variable.value
    if not isinstance(value, int):
        raise ValueError(f"object 0x{index:X}:{subindex:X} has no number as its value")
    return value
