"""The map on disk: killed at any moment, foreign, newer, locked, of another place; ids that are never used twice."""

import os
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from ods.base import clock
from ods.tracker.map import schema
from ods.tracker.map.hibernated import QUERY_MARGIN_M, HibernatedObjects
from ods.tracker.map.keeper import MapKeeper
from ods.tracker.map.link import OBJECTS_A_PACKET
from ods.tracker.map.map_object import MapObject
from ods.tracker.map.schema import SCHEMA_VERSION
from ods.tracker.map.store import MapError, copy_of_map, open_map
from ods.tracker.restart.ids import ID_BLOCK, provisional_first_id
from ods.tracker.settings import MapSettings

ORIGIN = (57.0, 10.0)


def rock(object_id: int, north: float = 0.0, east: float = 0.0, times_seen: int = 9) -> MapObject:
    return MapObject(
        object_id, (north, east, 4.0), (0.1, 0.2, 3.0), 1.5, 0.1, 0.99, times_seen, 10**18, 10**18 + 1, 10**18 + 2
    )


WRITER = """
import sys
from pathlib import Path
from ods.tracker.map.map_object import MapObject
from ods.tracker.map.store import open_map

store = open_map(Path(sys.argv[1]), 57.0, 10.0)
for i in range(1, 1_000_000):
    pair = [MapObject(j, (1.0 * i, 2.0, 3.0), (1, 1, 1), 1.0, 1.0, 0.9, i, 1, 2, 3) for j in (2 * i, 2 * i + 1)]
    store.change(pair, [2 * i - 20, 2 * i - 19], 2 * i + 2)
    print(i, flush=True)
"""


def test_kill_9_in_the_middle_of_writing(tmp_path: Path) -> None:
    """Whatever the moment: the file opens, each change is there as a whole, ids go on."""
    path = tmp_path / "deeper" / "map.sqlite"
    for _ in range(4):
        with subprocess.Popen([sys.executable, "-c", WRITER, path], stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            last = 0
            for line in process.stdout:
                last = int(line)
                if last >= 30:
                    os.kill(process.pid, signal.SIGKILL)
                    break
        store = open_map(path, *ORIGIN)
        objects = store.load()
        ids = [o.id for o in objects]
        assert all(i ^ 1 in ids for i in ids)  # always in pairs
        assert max(ids) >= 2 * last
        assert all(o.position[0] == o.id // 2 for o in objects)
        assert store.first_free_id() > max(ids)
        store.close()


def test_objects_come_back_as_they_were(tmp_path: Path) -> None:
    store = open_map(tmp_path / "map", *ORIGIN)
    store.change([rock(3), rock(5, 1.5)], [])
    store.change([rock(5, 2.5)], [3, 77])
    store.close()
    again = open_map(tmp_path / "map", *ORIGIN)
    assert again.load() == [rock(5, 2.5)]
    again.close()


def test_files_that_are_not_a_map_of_this_place(tmp_path: Path) -> None:
    path = tmp_path / "map"
    open_map(path, *ORIGIN).close()
    with pytest.raises(MapError, match=r"site\.latitude_deg"):
        open_map(path, 56.0, 10.0)
    with sqlite3.connect(path) as db:
        db.execute("PRAGMA user_version = 99")
    with pytest.raises(MapError, match="schema version 99"):
        open_map(path, *ORIGIN)
    (tmp_path / "text").write_text("this is no database, " * 500)
    with pytest.raises(MapError, match="not a database"):
        open_map(tmp_path / "text", *ORIGIN)
    with sqlite3.connect(tmp_path / "foreign") as db:
        db.execute("CREATE TABLE birds (name TEXT)")
    with pytest.raises(MapError, match="not a map"):
        open_map(tmp_path / "foreign", *ORIGIN)
    with pytest.raises(MapError):
        open_map(tmp_path / "text" / "map", *ORIGIN)


FIRST_SCHEMA = """
CREATE TABLE object (
    id INTEGER PRIMARY KEY,
    north REAL NOT NULL, east REAL NOT NULL, down REAL NOT NULL,
    sigma_north REAL NOT NULL, sigma_east REAL NOT NULL, sigma_down REAL NOT NULL,
    radius REAL NOT NULL, sigma_radius REAL NOT NULL,
    existence REAL NOT NULL, times_seen INTEGER NOT NULL,
    first_seen_utc_ns INTEGER NOT NULL, last_seen_utc_ns INTEGER NOT NULL, hibernated_utc_ns INTEGER NOT NULL
);
CREATE TABLE mission (latitude_deg REAL NOT NULL, longitude_deg REAL NOT NULL, next_id INTEGER NOT NULL);
PRAGMA application_id = 1329877837;
PRAGMA user_version = 1;
PRAGMA journal_mode = WAL;
INSERT INTO mission VALUES (57.0, 10.0, 41);
INSERT INTO object VALUES (3, 0.5, 1.0, 4.0, 0.1, 0.2, 3.0, 1.5, 0.1, 0.99, 9, 1, 2, 3);
INSERT INTO object VALUES (5, 9.5, 0.0, 4.0, 0.1, 0.2, 3.0, 1.5, 0.1, 0.99, 9, 1, 2, 3);
"""
"""A file as the first release of the map's schema left it."""


def first_schema(path: Path) -> Path:
    db = sqlite3.connect(path, isolation_level=None)
    db.executescript(FIRST_SCHEMA)
    db.close()
    return path


def test_a_map_of_the_first_schema_is_brought_up_to_date(tmp_path: Path) -> None:
    path = first_schema(tmp_path / "map")
    copy = copy_of_map(path)
    assert [o.id for o in copy.load((0.0, 0.0, 2.0))] == [3]
    with sqlite3.connect(path) as db:
        assert db.execute("PRAGMA user_version").fetchone() == (1,)  # reading changes nothing on disk
    db.close()
    store = open_map(path, *ORIGIN)
    assert [(o.id, o.position, o.covariance_ne) for o in store.load()] == [
        (3, (0.5, 1.0, 4.0), 0.0),
        (5, (9.5, 0.0, 4.0), 0.0),
    ]
    assert store.load() == copy.load()
    assert store.first_free_id() == 41
    store.close()
    with sqlite3.connect(path) as db:
        assert db.execute("PRAGMA user_version").fetchone() == (SCHEMA_VERSION,)
    db.close()


def test_a_step_that_fails_leaves_the_old_schema(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = first_schema(tmp_path / "map")
    with monkeypatch.context() as broken:
        broken.setattr(schema, "STEPS", (*schema.STEPS[:-1], (*schema.STEPS[-1], "NO SUCH STATEMENT")))
        with pytest.raises(MapError, match="syntax error"):
            open_map(path, *ORIGIN)
    store = open_map(path, *ORIGIN)
    assert len(store.load((0.0, 0.0, 2.0))) == 1
    store.close()


def test_the_r_tree_of_the_file_follows_every_change(tmp_path: Path) -> None:
    """Against a look at all objects: put, moved, removed at random; coordinates that single precision cannot hold."""
    rng = np.random.default_rng(2)
    store = open_map(tmp_path / "map", *ORIGIN)
    for _ in range(30):
        places = (1e6 + rng.uniform(-50.0, 50.0, (12, 2))).tolist()
        put = [rock(i, *place) for i, place in zip(rng.integers(1, 80, 12).tolist(), places, strict=True)]
        store.change(put, rng.integers(1, 80, 6).tolist())
        north, east = (1e6 + rng.uniform(-50.0, 50.0, 2)).tolist()
        near = [o for o in store.load() if np.hypot(o.position[0] - north, o.position[1] - east) <= 20.0]
        assert store.load((north, east, 20.0)) == near
    store.close()


class Keeper:
    """A keeper, what it complained of, and what it found in the file."""

    def __init__(self, path: Path | None, run_dir: Path) -> None:
        self.complaints: list[str] = []
        self.objects: list[MapObject] = []
        self.first_id: int | None = None
        self.keeper = MapKeeper(MapSettings(path=path), ORIGIN, run_dir, lambda key, _: self.complaints.append(key))

    def until(self, wanted: Callable[[], object], next_id: int = 1) -> None:
        """Go on until it is as wanted."""
        deadline = time.monotonic() + 60.0
        while not wanted():
            assert time.monotonic() < deadline, (self.complaints, self.problem())
            known = self.keeper.poll(clock.monotonic_ns(), next_id)
            if known is not None:
                self.objects += known.objects
                self.first_id = known.first_id
            time.sleep(0.002)

    def opened(self) -> "Keeper":
        self.until(lambda: not self.keeper.to_be_read)
        return self

    def written(self, next_id: int) -> None:
        self.until(lambda: not self.keeper.pending, next_id)

    def problem(self) -> str:
        return self.keeper.problem(clock.monotonic_ns())

    def killed(self) -> None:
        """Leave the map's process as a tracker does that is killed."""
        assert self.keeper._writer is not None
        self.keeper._writer.lost(0)


Make = Callable[[str], Keeper]


@pytest.fixture
def made(tmp_path: Path) -> Iterator[Make]:
    """Makes keepers of files in `tmp_path`."""
    keepers: list[Keeper] = []

    def make(name: str) -> Keeper:
        keepers.append(Keeper(tmp_path / name, tmp_path))
        return keepers[-1]

    yield make
    for each in keepers:
        each.keeper.close(1)


def test_ids_of_a_killed_tracker_are_not_used_again(made: Make) -> None:
    first = made("map").opened()
    assert (first.objects, first.first_id) == ([], 1)
    first.keeper.note([rock(7)], [])
    first.written(next_id=40)  # 39 ids were given out
    first.killed()
    second = made("map").opened()
    assert second.first_id is not None
    assert 40 <= second.first_id <= 40 + ID_BLOCK
    second.keeper.close(second.first_id + 2)  # a clean stop gives the rest back
    assert made("map").opened().first_id == second.first_id + 2


def test_provisional_ids_do_not_become_ordinary_ones(made: Make) -> None:
    """A tracker that could not read the map gave ids of its own; those of later missions go on where they were."""
    first = made("map").opened()
    provisional = provisional_first_id()
    first.keeper.note([rock(7), rock(provisional)], [])
    first.written(next_id=8)
    first.keeper.close(next_id=provisional + 1)
    second = made("map").opened()
    assert [o.id for o in second.objects] == [7, provisional]
    assert second.first_id == 1 + ID_BLOCK


def test_what_is_kept_and_how_far_it_is_relied_on_later(made: Make) -> None:
    first = made("map").opened()
    first.keeper.note([rock(1), rock(2), rock(3, times_seen=2), rock(4, north=float("nan"))], gone=[])
    first.written(4)
    assert (first.complaints, first.problem()) == (["map_not_finite"], "")
    first.keeper.note([], gone=[2])
    first.keeper.close(4)
    known = made("map").opened().objects
    assert [o.id for o in known] == [1]
    assert known[0].sigma == pytest.approx((0.50990195, 0.53851648, 3.0))


def test_more_objects_than_a_packet_holds(made: Make) -> None:
    objects = [rock(i + 1, north=1.0 * i) for i in range(2 * OBJECTS_A_PACKET + 7)]
    first = made("map").opened()
    first.keeper.note(objects[: OBJECTS_A_PACKET + 1], [])
    first.written(1000)
    first.keeper.note(objects, [])
    first.keeper.close(1000)
    assert [o.id for o in made("map").opened().objects] == [o.id for o in objects]


def test_a_map_that_fails_costs_the_map_only(made: Make, tmp_path: Path) -> None:
    (tmp_path / "map").write_text("rubbish " * 1000)
    broken = made("map")
    broken.until(broken.problem)
    broken.keeper.note([rock(1)], [])
    assert broken.complaints == ["map_unusable"]
    assert "not a database" in broken.problem()
    (tmp_path / "map").unlink()
    broken.opened()  # what is repaired is used
    broken.written(2)
    assert broken.problem() == ""


def test_a_locked_map_is_waited_for(made: Make, tmp_path: Path) -> None:
    """Nothing that was noted meanwhile is lost, an object that is gone again is never written, and it is said."""
    locked = made("map").opened()
    locked.keeper.note([rock(3)], [])
    locked.written(4)
    other = sqlite3.connect(tmp_path / "map", isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    locked.keeper.note([rock(1)], [])
    locked.until(lambda: "locked; not written for" in locked.problem(), 4)
    locked.keeper.note([rock(2, north=1.0)], [3])
    locked.keeper.note([rock(1, north=2.0)], [2])
    other.execute("COMMIT")
    other.close()
    locked.written(4)
    assert locked.problem() == ""
    locked.keeper.close(4)
    (left,) = made("map").opened().objects
    assert (left.id, left.position[0]) == (1, 2.0)


def test_the_map_process_is_started_again(made: Make) -> None:
    keeper = made("map").opened()
    keeper.keeper.note([rock(1)], [])
    assert keeper.keeper._writer is not None
    assert keeper.keeper._writer._process is not None
    keeper.keeper._writer._process.kill()
    keeper.until(lambda: "map_process_lost" in keeper.complaints)
    assert "its process ended" in keeper.problem()
    keeper.written(2)
    assert keeper.problem() == ""
    assert (keeper.objects, keeper.first_id) == ([], 1)  # nothing is handed out twice


def test_no_map_is_a_choice(tmp_path: Path) -> None:
    none = Keeper(None, tmp_path)
    assert not none.keeper.to_be_read
    none.keeper.note([rock(1)], [2])
    assert none.keeper.poll(0, 5) is None
    none.keeper.close(5)
    assert (none.complaints, none.problem(), len(none.keeper.pending)) == ([], "", 0)


def test_sleeping_objects_are_found_what_is_near_as_the_vehicle_goes_on() -> None:
    rng = np.random.default_rng(1)
    places = rng.uniform(-500.0, 500.0, (3000, 2))
    asleep = HibernatedObjects()
    asleep.put([rock(i + 1, float(place[0]), float(place[1])) for i, place in enumerate(places)])
    for step in range(60):
        centre = np.array([step * QUERY_MARGIN_M / 7.0, -3.0 * step])
        ids, found = asleep.places(centre, 100.0)
        expected = np.flatnonzero(np.hypot(*(places - centre).T) <= 100.0) + 1
        assert sorted(ids.tolist()) == expected.tolist()
        assert found.shape == (2, len(expected))
        if step == 30:
            asleep.wake([int(expected[0])])
            places[int(expected[0]) - 1] = np.nan
    assert len(asleep) == 2999


def test_ten_thousand_sleeping_objects_are_not_looked_at() -> None:
    """Between two steps of SKIN_M the R-tree is not asked at all, and what is far is not in the neighbourhood."""
    asleep = HibernatedObjects([rock(1, 60.0), *(rock(i, 5000.0 + i) for i in range(2, 10_002))])
    asked: list[str] = []
    asleep._tree.set_trace_callback(asked.append)
    for step in range(101):
        assert asleep.places(np.array([step * QUERY_MARGIN_M / 50.0, 0.0]), 100.0)[0].tolist() == [1]
    assert 2 <= sum("FROM place" in statement for statement in asked) <= 3
    assert asleep._near_ids.tolist() == [1]
