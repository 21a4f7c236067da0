"""The bag and the Foxglove file as the libraries of Foxglove and Lichtblick read them, in node.

`make npm` fetches these. Without them the tests are skipped; with ODS_REQUIRE_NPM in the environment, as in CI, that is
a failure.
"""

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ods.base.geodesy import LocalFrame
from ods.export.foxglove_file import TOPICS, FoxgloveFile
from ods.export.ros2 import Ros2Bag
from ods.export.sink import Sink
from tests.export import mission
from tests.export.mission import UTC_NS, A

PACKAGES = Path(__file__).parents[2] / "out" / "npm"
READER = Path(__file__).with_name("read_mcap.cjs")
SITE = LocalFrame(57.0, 10.0)


@pytest.fixture(scope="module")
def read() -> Callable[[Path], dict[str, list[Any]]]:
    """Return a function that returns the messages of a file by topic."""
    node = shutil.which("node")
    missing = "node" if node is None else "" if (PACKAGES / "node_modules").is_dir() else "packages: make npm"
    if missing and os.environ.get("ODS_REQUIRE_NPM"):
        pytest.fail(f"ODS_REQUIRE_NPM is set, and there is no {missing}")
    if node is None or missing:
        pytest.skip(f"no {missing}")

    def reader(path: Path) -> dict[str, list[Any]]:
        command = [node, str(READER), str(path), str(PACKAGES)]
        said = subprocess.run(command, capture_output=True, text=True, check=False)
        assert said.returncode == 0, said.stderr
        found: dict[str, list[Any]] = {}
        for line in map(json.loads, said.stdout.splitlines()):
            assert line["logTime"] == str(UTC_NS)
            found.setdefault(line["topic"], []).append(line["message"])
        return found

    return reader


def write(sink: Sink) -> None:
    for message in mission.ALL:
        sink.take(UTC_NS, message)
    sink.close()


def test_the_bag(read: Callable[[Path], dict[str, list[Any]]], tmp_path: Path) -> None:
    write(Ros2Bag(tmp_path / "bag", mission.MOUNTED))
    found = read(tmp_path / "bag" / "bag.mcap")
    (rock,) = found["/obstacles"][0]["obstacles"]
    assert rock["position"] == {"x": 60.0, "y": 110.0, "z": -12.0}
    assert rock["velocity"] == {"x": 0.2, "y": 0.1, "z": -0.3}
    assert rock["uuid"]["uuid"] == [*[0] * 15, 7]
    assert rock["position_covariance"] == pytest.approx([0.16, 0.01, 0, 0.01, 0.04, 0, 0, 0, 9.0])
    assert found["/odometry"][0]["twist"]["twist"]["linear"] == {"x": 1.5, "y": -0.2, "z": 0.1}
    (image,) = found["/sonar_image"]
    assert image["header"] == {"stamp": {"sec": 1_700_000_005, "nanosec": 250_000_000}, "frame_id": "sonar_fan"}
    assert image["image"]["data"] == [1, 0, 4, 0, 2, 0, 5, 0, 3, 0, 6, 1]
    assert image["beam_directions"][1] == pytest.approx({"x": 0.0, "y": 0.5, "z": 0.8660254}, abs=1e-7)
    assert found["/tf_static"][0]["transforms"][0]["transform"]["translation"] == {"x": 2.0, "y": -0.5, "z": -1.0}
    assert [s["status"][0]["level"] for s in found["/diagnostics"]] == [1, 2]


@pytest.fixture
def seen(read: Callable[[Path], dict[str, list[Any]]], tmp_path: Path) -> dict[str, list[Any]]:
    """Return the Foxglove file's messages by topic."""
    write(FoxgloveFile(tmp_path / "mission.mcap", mission.MOUNTED, SITE))
    found = read(tmp_path / "mission.mcap")
    assert set(found) == set(TOPICS)
    return found


def test_the_scene_of_a_foxglove_file(seen: dict[str, list[Any]]) -> None:
    (scene,) = seen["/obstacles"]
    (entity,) = scene["entities"]
    assert len(scene["deletions"]) == 1
    assert (entity["id"], entity["frame_id"]) == ("obstacle-7", "map")
    body, halo = entity["cylinders"]
    assert body["pose"]["position"] == {"x": 60.0, "y": 110.0, "z": -12.0}
    assert body["size"] == {"x": 3.0, "y": 3.0, "z": 3.0}
    # variances 0.16 to the east, 0.04 to the north, 0.01 in common: along the axes 0.10 +- sqrt(0.06^2 + 0.01^2)
    assert halo["size"]["x"] == pytest.approx(2 * (1.5 + 2 * 0.160828**0.5), abs=1e-5)
    assert halo["size"]["y"] == pytest.approx(2 * (1.5 + 2 * 0.039172**0.5), abs=1e-5)
    assert 2.0 * halo["pose"]["orientation"]["z"] == pytest.approx(0.08257, abs=1e-3)  # 0.5 atan(0.01 / 0.06)
    assert entity["texts"][0]["text"] == "7 \u00b10.4 m"
    reported = {pair["key"]: pair["value"] for pair in entity["metadata"]}
    assert (reported["existence"], reported["closest_approach_m"], reported["sigma_ned_m"]) == (
        "0.5",
        "2.5",
        "0.2, 0.4, 3",
    )


def test_frames_and_place_of_a_foxglove_file(seen: dict[str, list[Any]]) -> None:
    vehicle, head = seen["/tf"][0]["transforms"]
    assert (vehicle["parent_frame_id"], vehicle["child_frame_id"]) == ("map", "base_link")
    assert vehicle["translation"] == {"x": 20.0, "y": 100.0, "z": -10.0}
    assert abs(vehicle["rotation"]["w"]) == pytest.approx(1.0)  # heading east is along x
    assert head["translation"] == {"x": 2.0, "y": -0.5, "z": -1.0}
    assert head["rotation"] == pytest.approx({"x": 0.0, "y": A, "z": 0.0, "w": A})
    (fix,) = seen["/location"]
    # 100 m north: radius of the meridian at 57 deg is 6 380 400 m; 20 m east: 6 393 200 m times cos 57 deg
    assert fix["latitude"] == pytest.approx(57.0 + 100.0 / 6_380_400 * 57.29578, abs=2e-8)
    assert fix["longitude"] == pytest.approx(10.0 + 20.0 / (6_393_200 * 0.5446390) * 57.29578, abs=2e-8)
    assert fix["altitude"] == pytest.approx(-10.0, abs=2e-3)


def test_picture_and_log_of_a_foxglove_file(seen: dict[str, list[Any]]) -> None:
    (image,) = seen["/sonar/image"]
    assert (image["encoding"], image["step"]) == ("mono8", image["width"])
    assert len(image["data"]) == image["width"] * image["height"]
    (circle,) = seen["/sonar/detections"][0]["circles"]
    assert {pair["key"]: pair["value"] for pair in circle["metadata"]}["range_m"] == "30"
    assert [(line["name"], line["message"], line["level"]) for line in seen["/log"]] == [
        ("sonar", "no data, for 3 s", 3),
        ("obstacles", "no pose; sonar: silent", 3),
    ]
