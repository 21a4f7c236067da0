"""Logs of Oculus ViewPoint 2 (.oculus): an SQLite database. Each row of its table `data` has a time, ms, and a payload;
those of the sonar hold one message of its network stream.

Source of the layout: oculus-python (Technical University of Denmark), which reads such logs. The file may come from
anywhere: none of its own code runs.
"""

import math
import sqlite3
import struct
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from ods.base.files.in_file import opened
from ods.messages import Ping
from ods.sonar_link.files.decoder import Decoder
from ods.sonar_link.files.ping_sequence import LazyPings, PingFileError, PingSequence
from ods.sonar_link.files.viewpoint.message import check, is_ping, ping_of
from ods.sonar_link.oculus.messages import CHECK_WORD
from ods.sonar_link.sync_framer import MAX_PACKET_BYTES

FILE_MARK = b"SQLite format 3\0"
MS = 1000


class _Row(NamedTuple):
    id: int
    time_s: float


class OculusDatabaseDecoder(Decoder):
    """Counts `other_messages` (rows of other devices, too) and `corrupt_pings`.

    A ping's time is that of its row: when ViewPoint took it, UTC.
    """

    name = "Oculus .oculus, SQLite"
    signature = ((0, FILE_MARK),)

    def read(self, path: Path) -> PingSequence:
        """Read a log. Raises PingFileError."""
        losses: Counter[str] = Counter()
        try:
            with closing(_database(path)) as db:
                _check_table(db)
                found = [row for row in _rows(db, losses) if _holds_ping(db, row, losses)]
        except OSError as error:
            raise PingFileError(f"{path}: {error.strerror}") from error
        except (sqlite3.Error, ValueError) as error:
            raise PingFileError(f"{path}: not a log of Oculus ViewPoint: {error}") from error
        if not found:
            raise PingFileError(f"{path}: no complete simple ping result in it")
        return PingSequence(LazyPings(len(found), lambda index: _ping(path, found[index], index)), losses=losses)


def _database(path: Path) -> sqlite3.Connection:
    """Open a file that is only read. Raises OSError, sqlite3.Error."""
    opened(path).close()  # says why a file cannot be read: SQLite does not
    db = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro&immutable=1", uri=True)
    db.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_PACKET_BYTES)
    db.text_factory = bytes  # a damaged text is no text
    db.execute("PRAGMA trusted_schema = OFF")
    return db


def _check_table(db: sqlite3.Connection) -> None:
    """Raise ValueError where `data` is no plain table: a view, or one of a module, may compute without end."""
    query = "SELECT sql FROM sqlite_master WHERE type = 'table' AND name = 'data' COLLATE NOCASE"
    (sql,) = db.execute(query).fetchone() or (None,)
    if not isinstance(sql, bytes) or not sql.upper().startswith(b"CREATE TABLE"):
        raise ValueError("it has no table of data")


def _rows(db: sqlite3.Connection, losses: Counter[str]) -> Iterator[_Row]:
    """Yield each row, as far as the table is whole; ids rise, except in a damaged file, which may go in circles."""
    last = -math.inf
    rows = db.execute("SELECT rowid, timestamp FROM data ORDER BY rowid")
    try:
        for number, time_ms in rows:
            if not isinstance(number, int) or number <= last:
                raise sqlite3.DatabaseError("ids do not rise")
            last = number
            yield _Row(number, time_ms / MS if isinstance(time_ms, int | float) else math.nan)
    except sqlite3.DatabaseError:
        losses["corrupt_pings"] += 1


def _holds_ping(db: sqlite3.Connection, row: _Row, losses: Counter[str]) -> bool:
    try:
        payload = _payload(db, row)
        if payload.startswith(CHECK_WORD):
            check(payload)
            if is_ping(payload):
                ping_of(payload, row.time_s, 0)
                return True
        losses["other_messages"] += 1
    except (ValueError, struct.error, sqlite3.Error):
        losses["corrupt_pings"] += 1
    return False


def _payload(db: sqlite3.Connection, row: _Row) -> bytes:
    """Return what a row holds; nothing where that are no bytes. Raises sqlite3.Error, also beyond MAX_PACKET_BYTES."""
    (payload,) = db.execute("SELECT payload FROM data WHERE rowid = ?", (row.id,)).fetchone() or (b"",)
    return payload if isinstance(payload, bytes) else b""


def _ping(path: Path, row: _Row, index: int) -> Ping:
    try:
        with closing(_database(path)) as db:
            return ping_of(_payload(db, row), row.time_s, index)
    except (OSError, sqlite3.Error, struct.error, ValueError) as error:
        raise PingFileError(f"{path}: the file has changed: {error}") from error
