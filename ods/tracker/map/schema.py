"""Versions of the map file (`PRAGMA user_version`), and the steps from each to the next.

A new file takes all steps from version 0, so that there is one way to today's schema. A step once released is never
changed. Reading an old file needs no step on disk: readers work on a copy in memory (`store.copy_of_map`).
"""

import sqlite3

PLACE_TABLE = "CREATE VIRTUAL TABLE place USING rtree(id, north_min, north_max, east_min, east_max)"
"""The R-tree of places: in the map file, and in memory for objects that sleep. It holds single precision numbers,
rounded outwards: what it finds in a box is looked at once more exactly."""
INSIDE = "north_max >= ? AND north_min <= ? AND east_max >= ? AND east_min <= ?"
"""Condition on `place`; takes the four numbers of `square_around`."""
MAP_APPLICATION_ID = 0x4F44534D
"""`ODSM`: tells this file from other SQLite files."""

STEPS: tuple[tuple[str, ...], ...] = (
    (
        """CREATE TABLE object (
            id INTEGER PRIMARY KEY,
            north REAL NOT NULL, east REAL NOT NULL, down REAL NOT NULL,
            sigma_north REAL NOT NULL, sigma_east REAL NOT NULL, sigma_down REAL NOT NULL,
            radius REAL NOT NULL, sigma_radius REAL NOT NULL,
            existence REAL NOT NULL, times_seen INTEGER NOT NULL,
            first_seen_utc_ns INTEGER NOT NULL, last_seen_utc_ns INTEGER NOT NULL, hibernated_utc_ns INTEGER NOT NULL
        )""",
        "CREATE TABLE mission (latitude_deg REAL NOT NULL, longitude_deg REAL NOT NULL, next_id INTEGER NOT NULL)",
        f"PRAGMA application_id = {MAP_APPLICATION_ID}",
    ),
    (
        "ALTER TABLE object ADD COLUMN covariance_ne REAL NOT NULL DEFAULT 0",
        PLACE_TABLE,
        """CREATE TRIGGER place_of_new AFTER INSERT ON object BEGIN
            INSERT OR REPLACE INTO place VALUES (new.id, new.north, new.north, new.east, new.east);
        END""",
        """CREATE TRIGGER place_moved AFTER UPDATE OF id, north, east ON object BEGIN
            DELETE FROM place WHERE id = old.id;
            INSERT OR REPLACE INTO place VALUES (new.id, new.north, new.north, new.east, new.east);
        END""",
        "CREATE TRIGGER place_gone AFTER DELETE ON object BEGIN DELETE FROM place WHERE id = old.id; END",
        "INSERT INTO place SELECT id, north, north, east, east FROM object",
    ),
)
SCHEMA_VERSION = len(STEPS)


def version_of(db: sqlite3.Connection) -> int:
    """Return the schema version; 0 for an empty file. Raises ValueError when it is not a map or a newer one."""
    version = int(db.execute("PRAGMA user_version").fetchone()[0])
    empty = version == 0 and not db.execute("SELECT 1 FROM sqlite_master").fetchone()
    if not empty and (version < 1 or db.execute("PRAGMA application_id").fetchone()[0] != MAP_APPLICATION_ID):
        raise ValueError("not a map of this program")
    if version > SCHEMA_VERSION:
        raise ValueError(f"schema version {version}, this program knows {SCHEMA_VERSION}")
    return version


def bring_up_to_date(db: sqlite3.Connection) -> None:
    """Take a map, or an empty file, to the newest schema. The caller has opened the transaction and commits it."""
    for step in STEPS[version_of(db) :]:
        for statement in step:
            db.execute(statement)
    db.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")


def square_around(north: float, east: float, distance: float) -> tuple[float, float, float, float]:
    """Return the square around a place that holds all places not farther than `distance`."""
    return north - distance, north + distance, east - distance, east + distance
