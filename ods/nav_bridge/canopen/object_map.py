"""Map from the INS's objects to pose fields: the settings' table, checked."""

import re
from collections.abc import Mapping
from typing import NamedTuple

from ods.base.choices import none_of
from ods.base.errors import OdsError
from ods.nav_bridge.pose_fields import OPTIONAL, UNITS
from ods.nav_bridge.settings import POSE_OBJECTS, ObjectSettings

SEQUENCE_FIELD, STATUS_FIELD, TIME_FIELD = CONTROL_FIELDS = "sequence", "status", "time_of_day"
"""What an object may be beside a pose field. Only the sequence number may come from several objects."""
OBJECT = re.compile(r"0x([0-9a-fA-F]{1,4})(?::([0-9]{1,3}))?")
KEY = "nav.canopen.objects"

ObjectAddress = tuple[int, int]
"""Index and sub-index."""


class MappedObject(NamedTuple):
    """One object that PDOs carry."""

    name: str
    """As the settings name it."""
    field: str
    factor: float | None
    """None: that of the EDS."""
    is_optional: bool = False
    """An EDS is as good without it."""


def object_map(objects: Mapping[str, str | ObjectSettings]) -> dict[ObjectAddress, MappedObject]:
    """Return what each object is; of the default, what is optional may lack. Raises OdsError: one line with the key."""
    found: dict[ObjectAddress, MappedObject] = {}
    usual = {name: _field(entry) for name, entry in objects.items()} == POSE_OBJECTS
    for name, entry in objects.items():
        where, factor = _where(name), entry.factor if isinstance(entry, ObjectSettings) else None
        field = _field(entry)
        if field not in UNITS and field not in CONTROL_FIELDS:
            raise OdsError(f"{KEY}.{name}: not a pose field: {none_of(field, sorted({*UNITS, *CONTROL_FIELDS}))}")
        if field in CONTROL_FIELDS and factor is not None:
            raise OdsError(f"{KEY}.{name}: {field} has no factor")
        if where in found:
            raise OdsError(f"{KEY}.{name}: the same object as {found[where].name}")
        twin = next((other.name for other in found.values() if other.field == field != SEQUENCE_FIELD), None)
        if twin:
            raise OdsError(f"{KEY}.{name}: {twin} is {field} already")
        found[where] = MappedObject(name, field, factor, usual and field in OPTIONAL)
    return found


def _field(entry: str | ObjectSettings) -> str:
    return entry.field if isinstance(entry, ObjectSettings) else entry


def _where(name: str) -> ObjectAddress:
    match = OBJECT.fullmatch(name)
    subindex = int(match[2] or 0) if match else 0
    if match is None or subindex > 254:
        raise OdsError(f'{KEY}.{name}: expected a name like "0x2010:1": hexadecimal index, decimal sub-index')
    return int(match[1], 16), subindex
