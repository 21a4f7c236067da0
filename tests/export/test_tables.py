"""CSV and GeoJSON as Python's own readers and a closed form give them back."""

import csv
import json
import math
from pathlib import Path
from typing import Any

import msgspec
import pytest

from ods.base.geodesy import LocalFrame
from ods.export.csv_tables import COLUMNS, CsvTables
from ods.export.geojson import GeoJsonFile, Tracks
from ods.messages import ObstacleList
from tests.export import mission
from tests.export.mission import UTC_NS


@pytest.fixture
def tables(tmp_path: Path) -> dict[str, list[dict[str, str]]]:
    """Return the rows of all tables that the mission makes."""
    sink = CsvTables(tmp_path / "tables")
    for message in mission.ALL:
        sink.take(UTC_NS, message)
    sink.close()
    found = {}
    for path in (tmp_path / "tables").iterdir():
        with path.open(newline="", encoding="utf-8") as file:
            found[path.stem] = list(csv.DictReader(file))
    return found


def test_each_table_has_its_columns_filled(tables: dict[str, list[dict[str, str]]]) -> None:
    assert set(tables) == set(COLUMNS)
    for name, rows in tables.items():
        (row,) = rows
        assert tuple(row) == COLUMNS[name]
        assert None not in row.values()  # no row is shorter than its heading
        assert row["utc_ns"] == str(UTC_NS)


def test_the_values_of_the_tables(tables: dict[str, list[dict[str, str]]]) -> None:
    rock, pose, echo = tables["obstacles"][0], tables["poses"][0], tables["detections"][0]
    assert (rock["north_m"], rock["v_down_mps"], rock["sigma_east_m"]) == ("110.0", "0.3", "0.4")
    assert (rock["cpa_distance_m"], rock["height_above_bottom_m"], rock["valid"]) == ("2.5", "", "False")
    assert (pose["east_m"], pose["v_starboard_mps"], pose["altitude_m"]) == ("20.0", "0.2", "7.5")
    assert (echo["range_m"], echo["bearing_rad"], echo["sigma_radius_m"]) == ("30.0", "0.25", "0.2")
    assert tables["lists"][0]["reasons"] == "no pose; sonar: silent"
    assert tables["health"][0]["problems"] == "no data, for 3 s"
    assert json.loads(tables["health"][0]["counters"]) == {"bad_record": 2}


def sightings(frame: LocalFrame, steps: int) -> dict[str, Any]:
    """Return the GeoJSON of a vehicle that goes east and an object that goes north, 1 m a step."""
    tracks = Tracks(frame)
    for n in range(steps):
        stamp_ns = UTC_NS + n * 1_000_000_000
        tracks.add(stamp_ns, msgspec.structs.replace(mission.POSE, position_ned=(0.0, float(n), 10.0)))
        moved = msgspec.structs.replace(mission.ROCK, position_ned=(float(n), 0.0, 12.0), last_seen_utc_ns=stamp_ns)
        tracks.add(stamp_ns, msgspec.structs.replace(mission.LIST, obstacles=[moved]))
    found: dict[str, Any] = json.loads(json.dumps(tracks.collection()))
    return found


def test_tracks_on_the_earth(tmp_path: Path) -> None:
    sink = GeoJsonFile(tmp_path / "tracks.geojson", LocalFrame(0.0, 10.0))
    sink.take(UTC_NS, mission.POSE)
    sink.take(UTC_NS, mission.LIST)
    sink.close()
    vehicle, rock = json.loads((tmp_path / "tracks.geojson").read_text())["features"]
    # on the equator a degree to the east is a (pi / 180), one to the north a (1 - e^2) (pi / 180)
    east, north = math.radians(6378137.0), math.radians(6378137.0 * (1.0 - 0.00669438))
    assert rock["geometry"]["type"] == "Point"
    assert rock["geometry"]["coordinates"] == pytest.approx([10.0 + 60.0 / east, 110.0 / north, -12.0], abs=2e-3)
    assert rock["geometry"]["coordinates"][:2] == pytest.approx([10.0 + 60.0 / east, 110.0 / north], abs=2e-7)
    assert (rock["id"], rock["properties"]["state"], rock["properties"]["east_m"]) == (7, "active", 60.0)
    assert vehicle["geometry"]["coordinates"][:2] == pytest.approx([10.0 + 20.0 / east, 100.0 / north], abs=2e-7)
    assert vehicle["properties"]["begin_utc"] == "2023-11-14T22:13:25.250Z"


def test_what_moved_has_a_line_and_what_did_not_has_none() -> None:
    moved = sightings(LocalFrame(57.0, 10.0), 5)["features"]
    assert [f["id"] for f in moved] == ["vehicle", 7, "track-7"]
    assert len(moved[2]["geometry"]["coordinates"]) == 5
    assert [f["id"] for f in sightings(LocalFrame(57.0, 10.0), 1)["features"]] == ["vehicle", 7]


def test_who_never_moved_is_a_point_on_either_side_of_the_date_line() -> None:
    still = Tracks(LocalFrame(57.0, 10.0))
    for seconds in range(3):
        still.add(UTC_NS + seconds, mission.POSE)
    (vehicle,) = still.collection()["features"]
    assert vehicle["geometry"]["type"] == "Point"
    for metres in (1.0, 0.0):  # so far is the first of two steps of 1 m before the date line
        tracks = Tracks(LocalFrame(0.0, 179.99999 - metres * 9e-6))
        for east in range(4):
            moved = msgspec.structs.replace(mission.POSE, position_ned=(0.0, float(east), 0.0))
            tracks.add(UTC_NS, moved)
        (crossing,) = tracks.collection()["features"]
        parts = crossing["geometry"]["coordinates"]
        lines = parts if crossing["geometry"]["type"] == "MultiLineString" else [parts]
        assert all(len({tuple(node) for node in line}) > 1 for line in lines)


def test_no_property_is_a_number_here_and_a_text_there() -> None:
    features = sightings(LocalFrame(57.0, 10.0), 5)["features"]
    assert not any("id" in feature["properties"] for feature in features)
    assert [feature["properties"].get("object") for feature in features] == [None, 7, 7]


def test_a_line_across_the_date_line_is_cut_there() -> None:
    vehicle = sightings(LocalFrame(0.0, 179.99998), 6)["features"][0]["geometry"]
    assert vehicle["type"] == "MultiLineString"
    west, east = vehicle["coordinates"]
    assert all(node[0] > 179 for node in west)
    assert all(node[0] < -179 for node in east)


def test_what_is_no_number_is_left_out_of_geojson() -> None:
    lost = msgspec.structs.replace(mission.ROCK, position_ned=(math.nan, 0.0, 0.0), radius_m=math.inf)
    tracks = Tracks(LocalFrame(57.0, 10.0))
    tracks.add(UTC_NS, msgspec.structs.replace(mission.LIST, obstacles=[lost, mission.ROCK]))
    two: ObstacleList = msgspec.structs.replace(mission.LIST, obstacles=[msgspec.structs.replace(lost, id=8)])
    tracks.add(UTC_NS, two)
    text = json.dumps(tracks.collection(), allow_nan=False)
    assert [f["id"] for f in json.loads(text)["features"]] == [7]
