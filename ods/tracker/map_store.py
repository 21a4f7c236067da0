"""The map of hibernated objects on disk: one SQLite file in WAL mode, which survives a kill at any moment.

`PRAGMA user_version` holds the schema version. Ids are never used twice: the file remembers up to which id this and
earlier missions may have gone, so that an object of today never gets the id of one of last year.
"""

import sqlite3
from collections.abc import Iterable
from pathlib import Path

from ods.errors import OdsError
from ods.tracker.archive import MapObject

SCHEMA_VERSION = 1
APPLICATION_ID = 0x4F44534D
"""`ODSM`: tells this file from other SQLite files."""
ID_BLOCK = 1000
"""Ids are reserved on disk by so many at a time."""
LOCK_WAIT_S = 0.05
"""Longest wait for another program that reads or writes the file."""

SCHEMA = f"""
CREATE TABLE object (
    id INTEGER PRIMARY KEY,
    north REAL NOT NULL, east REAL NOT NULL, down REAL NOT NULL,
    sigma_north REAL NOT NULL, sigma_east REAL NOT NULL, sigma_down REAL NOT NULL,
    radius REAL NOT NULL, sigma_radius REAL NOT NULL,
    existence REAL NOT NULL, times_seen INTEGER NOT NULL,
    first_seen_utc_ns INTEGER NOT NULL, last_seen_utc_ns INTEGER NOT NULL, hibernated_utc_ns INTEGER NOT NULL
);
CREATE TABLE mission (latitude_deg REAL NOT NULL, longitude_deg REAL NOT NULL, next_id INTEGER NOT NULL);
PRAGMA application_id = {APPLICATION_ID};
PRAGMA user_version = {SCHEMA_VERSION};
"""


class MapError(OdsError):
    """The map cannot be used; the text is one line."""


class MapStore:
    """The open map file of one tracker. Positions are local: the file belongs to one origin."""

    def __init__(self, path: Path, latitude_deg: float, longitude_deg: float) -> None:
        """Open or create the file. Raises MapError when it is damaged, foreign, newer, or of another origin."""
        self._path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._db = sqlite3.connect(path, timeout=LOCK_WAIT_S, isolation_level=None)
        except (OSError, sqlite3.Error) as error:
            raise MapError(f"map {path}: {error}") from error
        try:
            self._prepare(latitude_deg, longitude_deg)
        except sqlite3.Error as error:
            self._db.close()
            raise MapError(f"map {path}: {error}") from error
        except MapError:
            self._db.close()
            raise

    def _prepare(self, latitude_deg: float, longitude_deg: float) -> None:
        db = self._db
        version = db.execute("PRAGMA user_version").fetchone()[0]
        if version == 0 and not db.execute("SELECT 1 FROM sqlite_master").fetchone():
            db.execute("PRAGMA journal_mode = WAL")
            db.executescript(f"BEGIN IMMEDIATE; {SCHEMA} COMMIT;")
            db.execute("INSERT INTO mission VALUES (?, ?, 1)", (latitude_deg, longitude_deg))
        elif db.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
            raise MapError(f"map {self._path}: not a map of this program")
        elif version != SCHEMA_VERSION:
            raise MapError(f"map {self._path}: schema version {version}, this program knows {SCHEMA_VERSION}")
        db.execute("PRAGMA journal_mode = WAL")
        db.execute("PRAGMA synchronous = NORMAL")
        latitude, longitude = db.execute("SELECT latitude_deg, longitude_deg FROM mission").fetchone()
        if (latitude, longitude) != (latitude_deg, longitude_deg):
            raise MapError(
                f"map {self._path}: its origin is {latitude}, {longitude}; "
                f"site.latitude_deg and site.longitude_deg are {latitude_deg}, {longitude_deg}"
            )

    def load(self) -> list[MapObject]:
        """Return all objects. Raises MapError."""
        try:
            rows = self._db.execute("SELECT * FROM object ORDER BY id").fetchall()
        except sqlite3.Error as error:
            raise MapError(f"map {self._path}: {error}") from error
        return [MapObject(r[0], r[1:4], r[4:7], *r[7:]) for r in rows]

    def change(self, put: Iterable[MapObject], remove: Iterable[int]) -> None:
        """Insert or replace objects and remove others by id, all or nothing. Raises MapError."""
        rows = [
            (
                *(o.id, *o.position, *o.sigma, o.radius, o.sigma_radius, o.existence, o.times_seen),
                *(o.first_seen_utc_ns, o.last_seen_utc_ns, o.hibernated_utc_ns),
            )
            for o in put
        ]
        try:
            with self._db:
                self._db.execute("BEGIN IMMEDIATE")
                self._db.executemany(f"INSERT OR REPLACE INTO object VALUES ({','.join('?' * 14)})", rows)
                self._db.executemany("DELETE FROM object WHERE id = ?", [(i,) for i in remove])
        except sqlite3.Error as error:
            raise MapError(f"map {self._path}: {error}") from error

    def first_free_id(self) -> int:
        """Return an id from which on none was ever used. Raises MapError."""
        try:
            (highest,) = self._db.execute("SELECT coalesce(max(id), 0) FROM object").fetchone()
            (next_id,) = self._db.execute("SELECT next_id FROM mission").fetchone()
        except sqlite3.Error as error:
            raise MapError(f"map {self._path}: {error}") from error
        return max(int(next_id), int(highest) + 1)

    def reserve(self, next_id: int) -> None:
        """Note that all ids below `next_id` may be in use. Raises MapError."""
        try:
            self._db.execute("UPDATE mission SET next_id = ?", (next_id,))
        except sqlite3.Error as error:
            raise MapError(f"map {self._path}: {error}") from error

    def close(self) -> None:
        """Close the file."""
        self._db.close()
