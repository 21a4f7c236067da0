"""The map of hibernated objects on disk: one SQLite file in WAL mode, which survives a kill at any moment.

Ids are never used twice: the file remembers up to which id this and earlier missions may have gone, so that an object
of today never gets the id of one of last year. Positions are local: a file belongs to one origin.
"""

import math
import os
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ods.base.errors import OdsError, reason_of
from ods.base.files.in_file import MOST_BYTES, opened
from ods.tracker.map.map_object import MapObject
from ods.tracker.map.rights import missing_permission
from ods.tracker.map.schema import INSIDE, SCHEMA_VERSION, bring_up_to_date, square_around, version_of
from ods.tracker.map.trust import MOST_OBJECTS, check_schema, lift_time_limit, mission_of, object_of, set_bounds
from ods.tracker.restart.ids import PROVISIONAL_IDS

LOCK_WAIT_S = 2.0
"""Longest wait for another program that reads or writes the file."""
OBJECT_COLUMNS = (
    "id, north, east, down, sigma_north, sigma_east, sigma_down, radius, sigma_radius, existence, times_seen, "
    "first_seen_utc_ns, last_seen_utc_ns, hibernated_utc_ns, covariance_ne"
)


class MapError(OdsError):
    """The map cannot be used; the text is one line."""


class MapStore:
    """An open map. Made by `open_map`, `copy_of_map` or `sole_access`; every method may raise MapError."""

    def __init__(self, path: Path, db: sqlite3.Connection) -> None:
        """`db`: a map of today's schema, in autocommit mode; `path` is for messages."""
        self._path = path
        self._db = db

    def origin_deg(self) -> tuple[float, float]:
        """Return latitude and longitude of the local frame's origin."""
        with _errors_named(self._path):
            latitude, longitude, _ = self._mission()
        return latitude, longitude

    def load(self, area: tuple[float, float, float] | None = None) -> list[MapObject]:
        """Return all objects, or those within `area`: north, east and distance, m. In order of their ids."""
        query, square = f"SELECT {OBJECT_COLUMNS} FROM object", tuple[float, ...]()
        if area is not None:
            query += f" WHERE id IN (SELECT id FROM place WHERE {INSIDE})"
            square = square_around(*area)
        with _errors_named(self._path):
            rows = self._db.execute(f"{query} ORDER BY id LIMIT {MOST_OBJECTS + 1}", square)
            found = [object_of(row) for row in rows]
            if len(found) > MOST_OBJECTS:
                raise ValueError(f"more than {MOST_OBJECTS} objects, the limit for a map in memory")
        if area is None:
            return found
        north, east, distance = area
        return [o for o in found if math.hypot(o.position[0] - north, o.position[1] - east) <= distance]

    def change(self, put: Iterable[MapObject], remove: Iterable[int], next_id: int | None = None) -> None:
        """Insert or replace objects and remove others by id, all or nothing; all ids below `next_id` may be in use."""
        rows = [
            (
                *(o.id, *o.position, *o.sigma, o.radius, o.sigma_radius, o.existence, o.times_seen),
                *(o.first_seen_utc_ns, o.last_seen_utc_ns, o.hibernated_utc_ns, o.covariance_ne),
            )
            for o in put
        ]
        with _errors_named(self._path), self._db:
            self._db.execute("BEGIN IMMEDIATE")
            self._db.executemany(
                f"INSERT OR REPLACE INTO object ({OBJECT_COLUMNS}) VALUES ({','.join('?' * 15)})", rows
            )
            self._db.executemany("DELETE FROM object WHERE id = ?", [(i,) for i in remove])
            if next_id is not None:
                self._db.execute("UPDATE mission SET next_id = ?", (next_id,))

    def first_free_id(self) -> int:
        """Return an id from which on none was ever used."""
        with _errors_named(self._path):
            ordinary = "SELECT coalesce(max(id), 0) FROM object WHERE id < ?"
            (highest,) = self._db.execute(ordinary, (PROVISIONAL_IDS,)).fetchone()
            _, _, next_id = self._mission()
        return max(int(next_id), int(highest) + 1)

    def _mission(self) -> tuple[float, float, int]:
        """Return the origin and the next id. Raises ValueError where the map is damaged."""
        return mission_of(self._db.execute("SELECT latitude_deg, longitude_deg, next_id FROM mission").fetchone())

    def image(self) -> bytes:
        """Return the map as the bytes of its file."""
        return self._db.serialize()

    def close(self) -> None:
        """Close the file."""
        self._db.close()


def open_map(path: Path, latitude_deg: float, longitude_deg: float) -> MapStore:
    """Open or create the map of a tracker, and bring it up to date.

    Raises MapError when the file is another user's, damaged, foreign, of a newer program or of another origin.
    """
    with _errors_named(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        if reason := missing_permission(path):
            raise ValueError(reason)
        db = sqlite3.connect(path, timeout=LOCK_WAIT_S, isolation_level=None)
    with _errors_named(path, db):
        set_bounds(db)
        check_schema(db)
        if version_of(db) < SCHEMA_VERSION:
            with db:
                db.execute("BEGIN IMMEDIATE")
                bring_up_to_date(db)
                unused = "WHERE NOT EXISTS (SELECT 1 FROM mission)"
                db.execute(f"INSERT INTO mission SELECT ?, ?, 1 {unused}", (latitude_deg, longitude_deg))
        db.execute("PRAGMA journal_mode = WAL")
        db.execute("PRAGMA synchronous = NORMAL")
        store = MapStore(path, db)
        latitude, longitude = store.origin_deg()
        if (latitude, longitude) != (latitude_deg, longitude_deg):
            raise ValueError(
                f"its origin is {latitude}, {longitude}; "
                f"site.latitude_deg and site.longitude_deg are {latitude_deg}, {longitude_deg}"
            )
        lift_time_limit(db)
    return store


def copy_of_map(path: Path) -> MapStore:
    """Return a copy in memory, of today's schema: the file may be in use, and is not changed. Raises MapError."""
    with _errors_named(path):
        _refuse_unreadable(path)
        db = sqlite3.connect(":memory:", isolation_level=None)
    with _errors_named(path, db):
        in_use = _has_log(path)
        _back_up(path, db, in_use)
        if not in_use and _has_log(path):  # a tracker has just opened it
            _back_up(path, db, in_use=True)
        if version_of(db) == 0:
            raise ValueError("not a map of ODS")
        set_bounds(db)
        check_schema(db)
        bring_up_to_date(db)
    return MapStore(path, db)


def _refuse_unreadable(path: Path) -> None:
    """Raise OSError or ValueError for what cannot be opened, which says why: SQLite does not."""
    with opened(path) as file:
        size = os.fstat(file.fileno()).st_size
    if size > MOST_BYTES:
        raise ValueError(f"{size / 1e9:.1f} GB: the limit for a map is {MOST_BYTES / 1e9:.0f} GB")


def _has_log(path: Path) -> bool:
    return path.with_name(f"{path.name}-wal").exists()


def _back_up(path: Path, db: sqlite3.Connection, in_use: bool) -> None:
    """Copy the file into `db`. One not in use is read without the files that SQLite would put beside it."""
    mode = "mode=ro" if in_use else "mode=ro&immutable=1"
    uri = f"{path.absolute().as_uri()}?{mode}"
    file = sqlite3.connect(uri, uri=True, timeout=LOCK_WAIT_S, isolation_level=None)
    try:
        file.execute("BEGIN")
        file.execute("SELECT 1 FROM sqlite_master").fetchone()  # takes the lock, or gives up: `backup` never would
        file.backup(db)
    finally:
        file.close()


def sole_access(path: Path) -> MapStore:
    """Open a map that no other program has open, and keep others out until it is closed.

    Raises MapError, also when a tracker is using the map: it would write back what is taken out here.
    """
    copy_of_map(path).close()  # says what is wrong with a file that is no map before anything is touched
    with _errors_named(path):
        db = sqlite3.connect(path, timeout=LOCK_WAIT_S, isolation_level=None)
    with _errors_named(path, db):
        db.execute("PRAGMA locking_mode = EXCLUSIVE")
        try:
            db.execute("PRAGMA journal_mode = DELETE")  # SQLite leaves WAL mode only if there is no other connection
            db.execute("PRAGMA journal_mode = WAL")  # and stays alone in it, as it never gives its lock back
            db.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError as error:
            raise ValueError(f"in use by another program, probably a running tracker ({error})") from error
        bring_up_to_date(db)
        db.execute("COMMIT")
    return MapStore(path, db)


@contextmanager
def _errors_named(path: Path, db: sqlite3.Connection | None = None) -> Iterator[None]:
    """Turn what goes wrong into a MapError that names the file; close `db` then, if given."""
    try:
        yield
    except (OSError, ValueError, sqlite3.Error, MapError) as error:
        if db is not None:
            db.close()
        raise error if isinstance(error, MapError) else MapError(f"map {path}: {reason_of(error)}") from error
