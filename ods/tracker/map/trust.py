"""Is a map file what it seems? It may come from elsewhere: none of its own code runs, no absurd number is believed."""

import math
import sqlite3
import time

from ods.tracker.map.map_object import MapObject
from ods.tracker.map.schema import STEPS

MOST_BYTES = 1_000_000_000
"""Largest file that is read: six million objects."""
PATIENCE_S = 30.0
"""Longest time for one file; a million objects take 3 s."""
FARTHEST_M = 1e7
"""No place, no size and no standard deviation is larger: the earth is not."""

_TABLES = ("object", "mission", "place")
_OWN_TRIGGERS = {sql.split()[2]: sql for step in STEPS for sql in step if sql.startswith("CREATE TRIGGER")}
_STEPS_A_LOOK = 100_000
"""Of SQLite's virtual machine."""


def set_bounds(db: sqlite3.Connection) -> None:
    """End what takes too long with sqlite3.OperationalError: interrupted."""
    end_s = time.monotonic() + PATIENCE_S
    db.set_progress_handler(lambda: time.monotonic() > end_s, _STEPS_A_LOOK)


def lift_time_limit(db: sqlite3.Connection) -> None:
    """Keep a file open that has been looked at."""
    db.set_progress_handler(None, 0)


def check_schema(db: sqlite3.Connection) -> None:
    """Raise ValueError where what should be a table is none, or where there is a trigger that is not ours.

    `trusted_schema` is off while it looks, and on again after: our own triggers write to an R-tree, which SQLite does
    not count among what an untrusted file may do.
    """
    db.execute("PRAGMA trusted_schema = OFF")
    rows = db.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
    tables = {name for kind, name, _ in rows if kind == "table"}
    if missing := [name for name in _TABLES if name not in tables and (name != "place" or len(rows) > len(_TABLES))]:
        raise ValueError(f"not a map of this program: {missing[0]} is no table")
    for kind, name, sql in rows:
        if kind == "view" or (kind == "trigger" and _OWN_TRIGGERS.get(name) != sql):
            raise ValueError(f"not a map of this program: it has a {kind} of its own, {name!r}")
    db.execute("PRAGMA trusted_schema = ON")


def check_object(o: MapObject) -> None:
    """Raise ValueError, which names the number, for an object that cannot be."""
    numbers = (*o.position, *o.sigma, o.radius, o.sigma_radius, o.existence, o.covariance_ne)
    if not all(map(math.isfinite, numbers)) or max(map(abs, numbers[:8])) > FARTHEST_M:
        raise ValueError(f"object {o.id} is damaged: a place or size is farther than {FARTHEST_M:g} m")
    if min(*o.sigma, o.radius, o.sigma_radius) < 0.0 or not 0.0 <= o.existence <= 1.0 or o.times_seen < 0:
        raise ValueError(f"object {o.id} is damaged: a size or probability is out of bounds")
    if abs(o.covariance_ne) > o.sigma[0] * o.sigma[1] * (1.0 + 1e-6):
        raise ValueError(f"object {o.id} is damaged: its covariance is larger than its standard deviations")
