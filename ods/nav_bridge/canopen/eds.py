"""EDS and DCF files, whoever wrote them: read with canopen, every failure one line.

As CiA 306 has them and tools write them, numbers may be octal (a leading 0), or left out; names of sections and keys in
any case; objects of many like sub-objects in compact form (`CompactSubObj`, with a `[xxxxValue]`). The canopen package
reads one form only. What cannot be read costs its own object only.
"""

import io
import re
from configparser import RawConfigParser
from pathlib import Path

from canopen import ObjectDictionary, import_od
from canopen.objectdictionary import datatypes

from ods.base.errors import OdsError, one_line
from ods.nav_bridge.encoding import read_text

MOST_SUBOBJECTS = 254
"""Of an object (CiA 301)."""
OBJECT = re.compile(r"([0-9A-F]{4})", re.IGNORECASE)
SUBOBJECT = re.compile(r"([0-9A-F]{4})sub([0-9A-F]{1,2})", re.IGNORECASE)
VALUES = re.compile(r"([0-9A-F]{4})Value", re.IGNORECASE)
NODE_ID = re.compile(r"\$NODEID", re.IGNORECASE)
NUMBER = re.compile(r"[+-]?(0[Xx][0-9A-Fa-f]{1,16}|[0-9]{1,20})")
OCTAL = re.compile(r"0[0-7]+")
VARIABLE, ARRAY, RECORD = 7, 8, 9
SECTION = "[{}]\n{}\n"

Options = dict[str, str]
"""Of a section, by the key in lower case."""


class EdsError(OdsError):
    """An EDS file cannot be used; the text says which and why."""


def read_dictionary(eds: Path, node_id: int, key: str) -> ObjectDictionary:
    """Read an EDS or DCF file, in UTF-8 or Latin-1, that the setting `key` names. Raises EdsError."""
    try:
        text = read_text(eds, "latin-1")
    except OSError as error:
        raise EdsError(f"{eds}: {key}: {error.strerror}") from error
    try:
        source = io.StringIO(canonical(text, node_id))
        source.name = str(eds)  # canopen recognizes the format by the name
        return import_od(source, node_id)
    except Exception as error:  # canopen lets through whatever a malformed file runs into
        raise EdsError(f"{eds}: {key}: not a usable EDS: {one_line(repr(error))}") from error


def number_of(dictionary: ObjectDictionary, index: int, subindex: int) -> int:
    """Return the DCF's value of an object, else its default. Raises ValueError when it has none."""
    variable = dictionary.get_variable(index, subindex)
    if variable is None:
        raise ValueError(f"object 0x{index:X}:{subindex:X} is missing")
    value = variable.default if variable.value is None else variable.value
    if not isinstance(value, int):
        raise ValueError(f"object 0x{index:X}:{subindex:X} has no numeric value")
    return value


def canonical(text: str, node_id: int) -> str:
    """Return a file's objects, their numbers decimal and `$NODEID` put in. Raises configparser.Error, ValueError."""
    parser = RawConfigParser(inline_comment_prefixes=(";",), strict=False, interpolation=None)
    parser.read_string(text)
    sections = {name: dict(parser.items(name)) for name in parser.sections()}
    objects = {int(m[1], 16): options for name, options in sections.items() if (m := OBJECT.fullmatch(name))}
    values = {int(m[1], 16): options for name, options in sections.items() if (m := VALUES.fullmatch(name))}
    subobjects: dict[tuple[int, int], Options] = {
        (int(m[1], 16), int(m[2], 16)): options
        for name, options in sections.items()
        if (m := SUBOBJECT.fullmatch(name))
    }
    for index, options in objects.items():
        for subindex, compact in _compact(options, values.get(index, {})).items():
            subobjects.setdefault((index, subindex), compact)
    parents = {index for index, _ in subobjects}
    written = [_object(index, options, node_id, index in parents) for index, options in objects.items()]
    written += [
        _variable(f"{index:04X}sub{subindex:X}", options, node_id)
        for (index, subindex), options in sorted(subobjects.items())
        if index in objects
    ]
    return SECTION.format("DeviceInfo", "") + "".join(written)


def number(text: str) -> int:
    """Return a number as CiA 306 writes it: decimal, hexadecimal, or octal. Raises ValueError."""
    text = text.strip()
    if NUMBER.fullmatch(text) is None:
        raise ValueError(f"{text[:40]!r} is no number")
    return int(text, 8) if OCTAL.fullmatch(text) else int(text, 16) if "x" in text.lower() else int(text)


def _compact(options: Options, values: Options) -> dict[int, Options]:
    """Return the sub-objects of one in compact form. Raises ValueError for more than can be."""
    count = _or(options.get("compactsubobj", ""), 0)
    if count > MOST_SUBOBJECTS:
        raise ValueError(f"CompactSubObj: {count} sub-objects, {MOST_SUBOBJECTS} are the most")
    if count <= 0:
        return {}
    named = {subindex: value for key, value in values.items() if (subindex := _or(key, -1)) >= 0}
    counted = named.get(0, str(count))
    found = {0: {"parametername": "count", "datatype": str(datatypes.UNSIGNED8), "defaultvalue": counted}}
    for subindex in range(1, count + 1):
        found[subindex] = options | {"defaultvalue": named.get(subindex, options.get("defaultvalue", ""))}
    return found


def _object(index: int, options: Options, node_id: int, is_parent: bool) -> str:
    name = f"{index:04X}"
    if not is_parent:
        return _variable(name, options, node_id)
    kind = ARRAY if _or(options.get("objecttype", ""), RECORD) == ARRAY else RECORD
    return SECTION.format(name, f"ParameterName={options.get('parametername', name)}\nObjectType={kind}\n")


def _variable(name: str, options: Options, node_id: int) -> str:
    """Return a section of what is read of an object; "" where its type cannot be."""
    try:
        kind = number(options.get("datatype", ""))
    except ValueError:
        return ""
    kept = {
        "ParameterName": options.get("parametername") or name,
        "ObjectType": str(VARIABLE),
        "DataType": str(kind),
        "AccessType": options.get("accesstype") or "ro",
        "PDOMapping": str(_or(options.get("pdomapping", ""), 0)),
    }
    for key in ("DefaultValue", "ParameterValue"):
        value = _value(options.get(key.lower(), ""), kind, node_id)
        kept |= {key: value} if value else {}
    if options.get("factor"):
        kept["Factor"] = options["factor"]
    return SECTION.format(name, "".join(f"{key}={value}\n" for key, value in kept.items()))


def _value(text: str, kind: int, node_id: int) -> str:
    """Return a value in decimals; "" where there is none, or none that can be read."""
    if kind not in datatypes.INTEGER_TYPES and kind != datatypes.BOOLEAN:
        return text
    rest, relative = NODE_ID.subn("", text)
    try:
        return (
            str(number(rest.replace(" ", "").strip("+") or "0") + (node_id if relative else 0)) if text.strip() else ""
        )
    except ValueError:
        return ""


def _or(text: str, otherwise: int) -> int:
    """Return a number, or another one where there is none."""
    try:
        return number(text)
    except ValueError:
        return otherwise
