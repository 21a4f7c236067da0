"""`ods map`: tables, GeoJSON, GeoPackage, merging and pruning, beside a running tracker and against bad files."""

import errno
import json
import signal
import sqlite3
import struct
import subprocess
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest

from ods.base import clock
from ods.base.geodesy import LocalFrame
from ods.cli import main
from ods.map.export import geojson, utc_text
from ods.tracker.map.map_object import MapObject
from ods.tracker.map.store import copy_of_map, open_map
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker

ORIGIN = (57.048, 10.05)
SEEN_NS = 1_790_000_000_123_456_789


def rock(object_id: int, north: float, east: float, **changes: object) -> MapObject:
    made = MapObject(
        object_id, (north, east, 20.0), (0.1, 0.2, 3.0), 1.5, 0.1, 0.95, 12, SEEN_NS + object_id, SEEN_NS, SEEN_NS
    )
    return msgspec.structs.replace(made, **changes)


def saved(path: Path, objects: list[MapObject], origin: tuple[float, float] = ORIGIN) -> Path:
    store = open_map(path, *origin)
    store.change(objects, [], max((o.id for o in objects), default=0) + 1)
    store.close()
    return path


def ids_in(path: Path) -> list[int]:
    store = copy_of_map(path)
    found = [o.id for o in store.load()]
    store.close()
    return found


@pytest.fixture
def field(tmp_path: Path) -> Path:
    return saved(tmp_path / "map.sqlite", [rock(1, 1234.5, -678.9), rock(2, -10.0, 5.0), rock(7, 0.0, 0.0)])


def run(*arguments: object) -> int:
    return main(["map", *map(str, arguments)])


def test_list(field: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("list", field) == 0
    _, first, *_, last = capsys.readouterr().out.splitlines()
    assert first.split() == [
        *("1", "1234.50", "-678.90", "20.00", "57.0590851", "10.0388110", "0.10/0.20/3.00", "1.50", "+-0.10"),
        *("0.950", "12", "2026-09-21T14:13:20.123Z"),
    ]
    assert last == "3 objects; origin 57.048, 10.05"
    assert run("list", field, "--within", -10, 0, 12) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()[1:-1]] == ["2", "7"]


def test_list_takes_the_map_of_the_configuration(
    field: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (Path(__file__).parents[2] / "config" / "onboard.toml").read_text()
    config = tmp_path / "onboard.toml"
    config.write_text(text.replace("~/.local/state/ods/map.sqlite", field.name))
    assert run("list", "--config", config) == 0
    assert "3 objects" in capsys.readouterr().out


def test_geojson(field: Path, tmp_path: Path) -> None:
    out = tmp_path / "map.geojson"
    assert run("export", field, "--out", out) == 0
    data = json.loads(out.read_text())
    assert set(data) == {"type", "bbox", "features"}  # RFC 7946 has no crs
    feature = data["features"][0]
    assert (data["type"], feature["type"], feature["id"]) == ("FeatureCollection", "Feature", 1)
    assert feature["geometry"] == {"type": "Point", "coordinates": [10.038811, 57.0590851, -19.845]}
    assert feature["properties"]["down_m"] == 20.0
    assert feature["properties"]["last_seen_utc"] == "2026-09-21T14:13:20.123Z"
    points = np.array([f["geometry"]["coordinates"] for f in data["features"]])
    assert data["bbox"] == [*points.min(axis=0), *points.max(axis=0)]


@pytest.mark.parametrize("suffix", ["geojson", "gpkg"])
def test_a_place_where_no_file_can_be_is_one_plain_line(
    field: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], suffix: str
) -> None:
    out = tmp_path / "absent" / f"map.{suffix}"
    assert run("export", field, "--out", out) == 2
    assert capsys.readouterr().err == f"ods map: {out}: no such folder: {out.parent}\n"
    out = tmp_path / f"{'x' * 245}.{suffix}"  # its own name is short enough, the unfinished file's is not
    assert run("export", field, "--out", out) == 2
    assert "[Errno" not in capsys.readouterr().err


def test_geojson_across_the_date_line_and_of_nothing() -> None:
    box = geojson([rock(1, 0.0, -400.0), rock(2, 0.0, 400.0)], LocalFrame(-16.5, 180.0))["bbox"]
    assert box[0] > 179.99
    assert box[3] < -179.99
    assert geojson([], LocalFrame(*ORIGIN)) == {"type": "FeatureCollection", "features": []}


def test_geopackage_has_what_the_standard_requires(field: Path, tmp_path: Path) -> None:
    """OGC 12-128: requirements 2, 10 to 14, 17, 19, 21 to 30. Read by GDAL too: docs/decisions/0005."""
    out = tmp_path / "map.gpkg"
    assert run("export", field, "--out", out) == 0
    db = sqlite3.connect(out)
    assert db.execute("PRAGMA application_id").fetchone() == (0x47504B47,)
    assert db.execute("PRAGMA user_version").fetchone() == (10300,)
    assert db.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    assert db.execute("PRAGMA foreign_key_check").fetchall() == []
    systems = db.execute("SELECT srs_id, organization, organization_coordsys_id FROM gpkg_spatial_ref_sys").fetchall()
    assert sorted(systems) == [(-1, "NONE", -1), (0, "NONE", 0), (4326, "EPSG", 4326), (4979, "EPSG", 4979)]
    (contents,) = db.execute("SELECT table_name, data_type, srs_id, min_x, max_y, last_change FROM gpkg_contents")
    assert contents[:3] == ("obstacles", "features", 4979)
    assert contents[3:5] == (10.038811, 57.0590851)
    assert contents[5].endswith("Z")
    geometry = db.execute("SELECT * FROM gpkg_geometry_columns").fetchall()
    assert geometry == [("obstacles", "geom", "POINT", 4979, 1, 0)]
    columns = [(c[1], c[2], c[5]) for c in db.execute("PRAGMA table_info(obstacles)")]
    assert columns[:2] == [("id", "INTEGER", 1), ("geom", "POINT", 0)]
    assert {kind for _, kind, _ in columns} <= {"INTEGER", "POINT", "DOUBLE", "DATETIME"}
    blob, down, seen = db.execute("SELECT geom, down_m, last_seen_utc FROM obstacles WHERE id = 1").fetchone()
    assert struct.unpack("<2sBBiBI3d", blob) == (b"GP", 0, 1, 4979, 1, 1001, 10.038811, 57.0590851, -19.845)
    assert (down, seen) == (20.0, "2026-09-21T14:13:20.123Z")
    db.close()
    assert run("export", saved(tmp_path / "none", []), "--out", out) == 0  # replaced, and empty is a map too


def test_merge_makes_a_map_that_a_tracker_starts_from(
    field: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second mission had another origin: 1 and 2 are known, 3 is new and gets an id that nobody had."""
    here, there = LocalFrame(*ORIGIN), LocalFrame(57.06, 10.07)
    places = there.ned(*here.geodetic([[1234.6, -678.9, 20.0], [-10.0, 5.1, 21.0], [80.0, 80.0, 20.0]]))
    other = saved(
        tmp_path / "other",
        [rock(i + 1, 0, 0, position=tuple(p), first_seen_utc_ns=i) for i, p in enumerate(places.tolist())],
        (57.06, 10.07),
    )
    out = tmp_path / "merged"
    before = field.read_bytes(), other.read_bytes()
    assert run("merge", field, other, "--out", out) == 0
    assert capsys.readouterr().out.splitlines() == [
        f"1 is 1 of {other}",
        f"2 is 2 of {other}",
        f"3 and 3 objects, 2 of them the same: 4 in {out}",
    ]
    assert (field.read_bytes(), other.read_bytes()) == before
    store = open_map(out, *ORIGIN)
    known, first_id = store.load(), store.first_free_id()
    store.close()
    tracker = Tracker(TrackerSettings(), known, first_id)
    assert sorted(tracker.snapshot().id.tolist()) == [1, 2, 7, 8]
    assert first_id == 9
    new = next(o for o in known if o.id == 8)
    assert new.position == pytest.approx((80.0, 80.0, 20.0), abs=1e-6)

    assert run("merge", field, other, "--out", out) == 2
    assert "already exists" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("criterion", "left"),
    [
        (("--existence-below", 0.5), [1, 3, 4, 5]),
        (("--older-than", 30), [1, 2, 4, 5]),
        (("--seen-fewer", 5), [1, 2, 3, 5]),
        (("--outside", 0, 0, 100), [1, 2, 3, 4]),
        (("--existence-below", 0.5, "--seen-fewer", 5), [1, 3, 5]),
    ],
)
def test_prune(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], criterion: tuple[object, ...], left: list[int]
) -> None:
    now, day = clock.utc_ns(), 86400 * clock.NS
    objects = [
        rock(1, 0.0, 0.0, last_seen_utc_ns=now),
        rock(2, 0.0, 0.0, last_seen_utc_ns=now, existence=0.4),
        rock(3, 0.0, 0.0, last_seen_utc_ns=now - 31 * day),
        rock(4, 0.0, 0.0, last_seen_utc_ns=now + day, times_seen=3),
        rock(5, -90.0, 90.0, last_seen_utc_ns=now),
    ]
    path = saved(tmp_path / "map", objects)
    assert run("prune", path, *criterion, "--dry-run") == 0
    assert "would be removed" in capsys.readouterr().out
    assert ids_in(path) == [1, 2, 3, 4, 5]
    assert run("prune", path, *criterion) == 0
    said = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in said[:-1]] == [str(i) for i in range(1, 6) if i not in left]
    assert ids_in(path) == left
    store = open_map(path, *ORIGIN)
    assert store.first_free_id() == 6  # no id is used again, even if its object is gone
    assert len(store.load((0.0, 0.0, 1000.0))) == len(left)
    store.close()


def test_a_map_that_may_not_be_written_is_in_nobodys_use(
    field: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("os.access", lambda place, mode: False)
    assert run("prune", field, "--seen-fewer", "99", "--dry-run") == 0
    assert run("prune", field, "--seen-fewer", "99") == 2
    assert "may not be written by user" in capsys.readouterr().err
    assert ids_in(field) == [1, 2, 7]


@pytest.mark.parametrize("action", ["list", "export", "prune", "merge"])
def test_a_map_that_may_not_be_read_says_so(
    field: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], action: str
) -> None:
    options = {
        "list": (),
        "export": ("--out", field.with_name("x.gpkg")),
        "prune": ("--seen-fewer", 2, "--dry-run"),
        "merge": (field, "--out", field.with_name("merged")),
    }

    def refused(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr("ods.tracker.map.store.opened", refused)
    monkeypatch.setattr("ods.map.commands.merge.load_table", refused)
    assert run(action, field, *options[action]) == 2
    assert capsys.readouterr().err == f"ods map: map {field}: permission denied\n"


def test_beside_a_running_tracker(field: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Reading works, even in the middle of a change, and sees whole changes; taking out is refused."""
    tracker = open_map(field, *ORIGIN)
    tracker.change([rock(9, 3.0, 3.0)], [])
    tracker._db.execute("BEGIN IMMEDIATE")
    tracker._db.execute("DELETE FROM object")
    assert ids_in(field) == [1, 2, 7, 9]
    assert run("export", field, "--out", tmp_path / "map.gpkg") == 0
    tracker._db.execute("COMMIT")
    assert ids_in(field) == []
    assert run("merge", field, field, "--out", tmp_path / "merged") == 0
    capsys.readouterr()
    assert run("prune", field, "--seen-fewer", 5) == 2
    assert "in use by another program" in capsys.readouterr().err
    tracker.change([rock(10, 0.0, 0.0)], [])  # and it has not noticed
    tracker.close()
    assert run("prune", field, "--seen-fewer", 5) == 0


KILLED_PRUNE = """
import os, signal, sys
from pathlib import Path
from ods.tracker.map.store import sole_access

store = sole_access(Path(sys.argv[1]))
store.change([], [7])
store._db.execute("BEGIN")
store._db.execute("DELETE FROM object")
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_prune_killed_half_way_leaves_a_whole_map(field: Path) -> None:
    assert subprocess.run([sys.executable, "-c", KILLED_PRUNE, field], check=False).returncode == -signal.SIGKILL
    assert ids_in(field) == [1, 2]
    assert run("prune", field, "--outside", 0, 0, 100) == 0
    assert ids_in(field) == [2]
    store = open_map(field, *ORIGIN)
    assert store.first_free_id() == 8
    store.close()


ENDLESS = "WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n) SELECT id, 0.0 AS north FROM n"


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("list", "nowhere"), "no such file"),
        (("list", "."), "is a directory"),
        (("list", "text"), "not a database"),
        (("export", "birds", "--out", "x.gpkg"), "not a map"),
        (("export", "empty", "--out", "x.gpkg"), "not a map"),
        (("list", "newer"), "schema version 99"),
        (("list", "damaged"), "object 1 is damaged"),
        (("list", "endless"), "table object has another layout"),
        (("merge", "good", "endless", "--out", "merged"), "table object has another layout"),
        (("prune", "triggered", "--seen-fewer", "2"), "unexpected trigger 'place_gone'"),
        (("list", "computed"), "table object has another layout"),
        (("list", "indexed"), "unexpected index 'mine'"),
        (("list", "virtual"), "unexpected table 'other'"),
        (("list", "later"), "a field is not a number"),
        (("list", "often"), "its number of sightings"),
        (("list", "spent"), "next id is out of bounds"),
        (("list", "moon"), "origin or next id is out of bounds"),
        (("list", "far"), "exceeds 1e+07 m"),
        (("merge", "good", "huge", "--out", "merged"), "exceeds 1e+07 m"),
        (("list", "negative"), "out of bounds"),
        (("export", "sure", "--out", "x.geojson"), "out of bounds"),
        (("list", "skewed"), "covariance is larger"),
        (("list", "lost"), "damaged: origin"),
        (("list", "words"), "damaged: origin"),
        (("prune", "newer", "--seen-fewer", "2"), "schema version 99"),
        (("prune", "birds", "--seen-fewer", "2"), "not a map"),
        (("prune", "good"), "say what to remove"),
        (("merge", "good", "birds", "--out", "merged"), "not a map"),
        (("export", "good", "--out", "x.shp"), "suffix"),
        (("export", "good", "--out", "no/folder/x.gpkg"), "no such folder"),
        (("export", "good", "--out", "no/folder/x.geojson"), "no such folder"),
    ],
)
def test_what_is_wrong_is_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: tuple[str, ...],
    complaint: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text").write_text("this is no database, " * 500)
    (tmp_path / "empty").touch()
    for name, statement in (
        ("birds", "CREATE TABLE birds (name TEXT)"),
        ("newer", "PRAGMA user_version = 99"),
        ("damaged", "UPDATE object SET radius = 'large' WHERE id = 1"),
        ("lost", "DELETE FROM mission"),
        ("words", "UPDATE mission SET latitude_deg = 'north'"),
        ("endless", f"DROP TABLE object; CREATE VIEW object AS {ENDLESS}"),
        ("triggered", "DROP TRIGGER place_gone; CREATE TRIGGER place_gone AFTER DELETE ON object BEGIN SELECT 1; END"),
        ("computed", "ALTER TABLE object ADD COLUMN big GENERATED ALWAYS AS (zeroblob(1000000000))"),
        ("indexed", "CREATE INDEX mine ON object (abs(north))"),
        ("virtual", "CREATE VIRTUAL TABLE other USING rtree(id, low, high)"),
        ("later", "UPDATE object SET last_seen_utc_ns = 1e300"),
        ("often", "UPDATE object SET times_seen = 9223372036854775807"),
        ("spent", "UPDATE mission SET next_id = 9223372036854775807"),
        ("moon", "UPDATE mission SET latitude_deg = 91"),
        ("far", "UPDATE object SET north = 1e12"),
        ("huge", "UPDATE object SET radius = 1e300"),
        ("negative", "UPDATE object SET sigma_north = -1"),
        ("sure", "UPDATE object SET existence = 1.5"),
        ("skewed", "UPDATE object SET covariance_ne = 100"),
        ("good", "PRAGMA user_version"),
    ):
        if name != "birds":
            saved(tmp_path / name, [rock(1, 0.0, 0.0)])
        with sqlite3.connect(name) as db:
            db.executescript(statement)
        db.close()
    files = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert run(*arguments) == 2
    said = capsys.readouterr().err
    assert said.startswith("ods map: ")
    assert complaint in said
    assert said.count("\n") == 1
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == files  # nothing left behind


def test_times_are_reported_in_utc() -> None:
    assert utc_text(0) == "1970-01-01T00:00:00.000Z"
    assert utc_text(-1) == "1969-12-31T23:59:59.999Z"
    assert utc_text(2**63 - 1) == "2262-04-11T23:47:16.854Z"
