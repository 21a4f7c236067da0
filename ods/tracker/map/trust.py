"""Validation of a map file, which may come from elsewhere: its code never runs, and implausible numbers are refused."""

import math
import sqlite3
import time
from functools import cache

from ods.base.files.in_file import MOST_BYTES, PATIENCE_S
from ods.tracker.map.map_object import MapObject
from ods.tracker.map.schema import STEPS, version_of
from ods.tracker.restart.ids import PROVISIONAL_IDS

MOST_OBJECTS = MOST_BYTES // 1000
"""As each takes about 1 kB in memory; a million is read in 3 s."""
FARTHEST_M = 1e7
"""No place, no size and no standard deviation is larger: the earth is not."""
MOST_TIMES_SEEN = 1 << 53
HIGHEST_ID = PROVISIONAL_IDS + MOST_TIMES_SEEN

_OURS = ("object", "mission", "place")
_STEPS_A_LOOK = 100_000
"""Of SQLite's virtual machine."""


def set_bounds(db: sqlite3.Connection) -> None:
    """End what takes too long with sqlite3.OperationalError: interrupted. `trusted_schema` is off from here on."""
    end_s = time.monotonic() + PATIENCE_S
    db.set_progress_handler(lambda: time.monotonic() > end_s, _STEPS_A_LOOK)
    db.execute("PRAGMA trusted_schema = OFF")


def lift_time_limit(db: sqlite3.Connection) -> None:
    """Keep a file open that has been looked at."""
    db.set_progress_handler(None, 0)


def check_schema(db: sqlite3.Connection) -> None:
    """Raise ValueError where one of our tables is not as we make it, or for what could run code of the file's own.

    A default, a generated column, a trigger, an index and a view all do when the file is read or written. Where there
    is none `trusted_schema` is on again: our triggers write to an R-tree, which an untrusted file may not.
    """
    ours = _schema_of(version_of(db))
    found = _stored_in(db)
    for name in _OURS:
        if name in ours and found.get(name) != ours[name]:
            raise ValueError(f"not a map of ODS: table {name} has another layout")
    for name, (kind, sql) in found.items():
        plain = not sql or (kind == "table" and not sql.upper().startswith("CREATEVIRTUAL"))
        if not plain and ours.get(name) != (kind, sql):
            raise ValueError(f"not a map of ODS: unexpected {kind} {name!r}")
    db.execute("PRAGMA trusted_schema = ON")


@cache
def _schema_of(version: int) -> dict[str, tuple[str, str]]:
    """Return what a map of a version has, as this SQLite writes it down."""
    db = sqlite3.connect(":memory:")
    try:
        for statement in (statement for step in STEPS[:version] for statement in step):
            db.execute(statement)
        return _stored_in(db)
    finally:
        db.close()


def _stored_in(db: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Return kind and SQL, without any blanks, of what a file has, by name."""
    rows = db.execute("SELECT type, name, sql FROM sqlite_master")
    return {name: (kind, "".join((sql or "").split())) for kind, name, sql in rows}


def object_of(row: tuple[object, ...]) -> MapObject:
    """Return the object of a row of the table. Raises ValueError, which names the number, for one that cannot be."""
    number, *sizes, times_seen, first_seen, last_seen, hibernated, covariance = row
    whole = number, times_seen, first_seen, last_seen, hibernated
    if not all(isinstance(value, int) for value in whole) or not all(map(_is_number, (*sizes, covariance))):
        raise ValueError(f"object {number} is damaged: a field is not a number")
    o = MapObject(number, row[1:4], row[4:7], *row[7:])  # type: ignore[arg-type]
    if max(map(abs, (*o.position, *o.sigma, o.radius, o.sigma_radius))) > FARTHEST_M:
        raise ValueError(f"object {o.id} is damaged: a position or size exceeds {FARTHEST_M:g} m")
    if min(*o.sigma, o.radius, o.sigma_radius) < 0.0 or not 0.0 <= o.existence <= 1.0:
        raise ValueError(f"object {o.id} is damaged: a size or probability is out of bounds")
    if not 0 <= o.times_seen <= MOST_TIMES_SEEN or not 0 <= o.id <= HIGHEST_ID:
        raise ValueError(f"object {o.id} is damaged: its id or its number of sightings is out of bounds")
    if abs(o.covariance_ne) > o.sigma[0] * o.sigma[1] * (1.0 + 1e-6):
        raise ValueError(f"object {o.id} is damaged: its covariance is larger than its standard deviations")
    return o


def mission_of(row: tuple[object, ...] | None) -> tuple[float, float, int]:
    """Return latitude and longitude, deg, and next id of a row of the table. Raises ValueError where they cannot be."""
    latitude_deg, longitude_deg, next_id = row or (None, None, None)
    if not _is_number(latitude_deg) or not _is_number(longitude_deg) or not isinstance(next_id, int):
        raise ValueError("damaged: origin and next id are missing")
    on_earth = abs(float(latitude_deg)) <= 90.0 and abs(float(longitude_deg)) <= 180.0  # type: ignore[arg-type]
    if not on_earth or not 0 <= next_id <= HIGHEST_ID:
        raise ValueError("damaged: origin or next id is out of bounds")
    return latitude_deg, longitude_deg, next_id  # type: ignore[return-value]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)
