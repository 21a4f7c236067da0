"""Logs of Oculus ViewPoint 2, made from the layout that oculus-python reads: the stream's pings, with times."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from ods.base.clock import NS
from ods.messages import frame_of
from ods.sonar_link.files.opening import PingFileError, open_pings
from tests.recordings import OCULUS, edited
from tests.sonar_link.test_decoder_oculus_log import messages

BEGUN_MS = 1_700_000_000_250
TABLE = """CREATE TABLE data (
    entryId INTEGER PRIMARY KEY, timestamp INT NOT NULL, type INT NOT NULL, dataSourceId INT, length INT NOT NULL,
    payload BLOB NOT NULL
)"""
ALL = "SELECT 1 AS entryId, 2 AS timestamp, x'00' AS payload"


def database(path: Path, *rows: tuple[object, object], table: str = TABLE) -> Path:
    """Write a log whose rows have these times, ms, and payloads."""
    with closing(sqlite3.connect(path)) as db:
        db.execute(table)
        for time_ms, payload in rows:
            db.execute("INSERT INTO data VALUES (NULL, ?, 1, 0, 0, ?)", (time_ms, payload))
        db.commit()
    return path


def test_the_pings_are_those_of_the_stream_with_their_times(tmp_path: Path) -> None:
    first, second, third = messages()
    rows = (BEGUN_MS, first), (BEGUN_MS + 50, b"of another device"), (BEGUN_MS + 100, second), (BEGUN_MS + 200, third)
    found, stream = open_pings(database(tmp_path / "dive.oculus", *rows)), open_pings(OCULUS)
    assert found.timed
    assert [ping.ping_number for ping in found.pings] == [415323, 415324, 415325]
    assert [ping.t_ns / NS for ping in found.pings] == pytest.approx(
        [1_700_000_000.25, 1_700_000_000.35, 1_700_000_000.45]
    )
    for ping, same in zip(found.pings, stream.pings, strict=True):
        assert frame_of(ping).tobytes() == frame_of(same).tobytes()
        assert (ping.bearing_rad, ping.dr_m, ping.range0_m) == (same.bearing_rad, same.dr_m, same.range0_m)
    assert found.losses == {"other_messages": 1}


def test_what_cannot_be_a_ping_is_counted(tmp_path: Path) -> None:
    first, second, _ = messages()
    rows = (
        ("soon", first), (-1, first), (BEGUN_MS, first[:5000]), (BEGUN_MS, bytes(5_000_000)), (BEGUN_MS, "text"),
        (BEGUN_MS, b"SO"), (BEGUN_MS, second),
    )  # fmt: skip
    found = open_pings(database(tmp_path / "bad.oculus", *rows))
    assert [ping.ping_number for ping in found.pings] == [415324]
    assert found.losses == {"corrupt_pings": 5, "other_messages": 1}


def test_a_log_that_is_damaged_gives_what_is_whole(tmp_path: Path) -> None:
    whole = database(tmp_path / "whole.oculus", *((BEGUN_MS + n, messages()[0]) for n in range(4)))
    middle = slice(whole.stat().st_size // 2, whole.stat().st_size // 2 + 10_000)
    found = open_pings(edited(tmp_path / "bad.oculus", whole, lambda data: data.__setitem__(middle, b"\xff" * 10_000)))
    assert len(found.pings) == 3
    assert found.losses == {"corrupt_pings": 1}


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("CREATE TABLE other (a)", "no table of data"),
        (f"CREATE VIEW data AS {ALL}", "no table of data"),
        ("CREATE VIRTUAL TABLE data USING rtree(a, b, c)", "no table of data"),
        ("CREATE TABLE data (a)", "no such column"),
        (TABLE, "no complete simple ping"),
    ],
)
def test_what_is_no_log_is_one_line(tmp_path: Path, table: str, said: str) -> None:
    with pytest.raises(PingFileError, match=said) as error:
        open_pings(database(tmp_path / "x.oculus", table=table))
    assert "\n" not in str(error.value)


def test_a_log_that_changes_while_it_is_read_is_one_line(tmp_path: Path) -> None:
    path = database(tmp_path / "gone.oculus", (BEGUN_MS, messages()[0]))
    found = open_pings(path)
    path.unlink()
    with pytest.raises(PingFileError, match="has changed"):
        found.pings[0]
