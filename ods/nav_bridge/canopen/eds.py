"""EDS and DCF files, whoever wrote them: read with canopen, every failure one line."""

import io
from pathlib import Path

from canopen import ObjectDictionary, import_od

from ods.base.errors import OdsError, one_line
from ods.nav_bridge.canopen.eds_text import canonical
from ods.nav_bridge.encoding import read_text


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
