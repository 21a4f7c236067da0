"""`ods assess sea`: what counts as tracked and as false, and a run of the command."""

import math
from pathlib import Path

import numpy as np
import pytest

from ods.assess.sea.assessment import names_of, shipped_scenes
from ods.assess.sea.judge import SceneScore, judge
from ods.assess.sea.run import Listed, images_of, scene_with_seed
from ods.assess.sea.scene_objects import SceneObjects
from ods.assess.sea.table import condensed, scene_table
from ods.cli import main
from ods.messages import Truth, TruthObject
from ods.sim_sonar.scene.settings import Cylinder, Plane, SceneFile, Sphere, VehiclePath
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.sea_bed.settings import Roughness, SeaBed
from ods.sim_sonar.sonar.model import load_sonar
from ods.tracker.existence import lifecycle

pytestmark = pytest.mark.slow

CONFIG = Path(__file__).parents[2] / "config"
HERE = VehiclePath(position_ned=(0.0, 0.0, 20.0))
Row = list[tuple[int, int, float, float, float]]
"""id, state, north, east, radius."""


def sphere(name: str, north: float, east: float, down: float = 20.0, radius_m: float = 1.0) -> Sphere:
    return Sphere(name=name, position_ned=(north, east, down), radius_m=radius_m)


def scene(*items: Sphere | Cylinder | Plane, depth_m: float = 25.0) -> Scene:
    return Scene(SceneFile(seed=1, vehicle=HERE, objects=list(items), sea_bed=SeaBed(depth_m=depth_m)))


def lists_of(
    lists_of_rows: list[Row], loud: list[float], names: tuple[str, ...] = ("ball",), unsettled: int = 0
) -> list[Listed]:
    """Return lists a second apart; loud: signal to noise ratio of all objects in each, which are at (50, 0).

    unsettled: so many of the first are not valid.
    """
    lists = []
    for k, (rows, snr_db) in enumerate(zip(lists_of_rows, loud, strict=True)):
        objects = [TruthObject(name, (50.0, 0.0, 20.0), (0.0, 0.0, 0.0), 1.0, True, snr_db, 0.0) for name in names]
        truth = Truth(k, k * 10**9, k * 10**9, (0.0, 0.0, 20.0), (1.0, 0.0, 0.0, 0.0), objects)
        table = np.array(rows, np.float64).reshape(-1, 5)
        number, state = table[:, 0].astype(int), table[:, 1].astype(int)
        lists.append(Listed(truth, 3, number, state, table[:, 2:4], table[:, 4], 1.0, 2.0, k >= unsettled, 9.0))
    return lists


def test_the_condensed_table_has_a_column_a_seed_and_names_what_is_missed() -> None:
    bodies = SceneObjects(scene(sphere("ball", 50.0, 0.0)), 1.0)
    near, away = (7, lifecycle.ACTIVE, 50.0, 0.5, 1.0), (8, lifecycle.ACTIVE, 80.0, 0.0, 1.0)
    lists = lists_of([[], [], [near], [near, away], [near, away]], [20.0] * 5)
    late, good = judge("bed", lists, bodies), judge("bed", lists_of([[near]] * 5, [20.0] * 5), bodies, seed=1)
    heading, line, row, total = condensed([late, good])
    cells = [cell.strip() for cell in row.strip("| ").split("|")]
    assert cells == ["bed", "15.0", "0.0", "ball 75%", "", "ball 2.00"]
    assert heading.count("|") == line.count("|") == row.count("|") == total.count("|") == 8
    assert "| 15.0 | 0.0 |" in total


def test_groups_of_what_has_to_be_tracked() -> None:
    wall = Plane(name="wall", position_ned=(90.0, 0.0, 22.0), normal_ned=(1.0, 0.0, 0.0), width_m=40.0, height_m=6.0)
    stalk = Cylinder(name="kelp 1/2", position_ned=(40.0, 0.0, 24.0), radius_m=0.1, length_m=4.0)
    low = sphere("kelp 1/1", 40.0, 1.0, 24.9, 0.2)
    found = SceneObjects(
        scene(wall, stalk, low, sphere("ball", 50.0, 0.0), sphere("stone", 60.0, 0.0, 24.6, 0.5),
              sphere("surface/1", 30.0, 0.0, 1.0)), 1.0
    )  # fmt: skip
    assert found.targets == ["ball", "kelp 1"]
    assert found.groups == ["wall", "kelp 1", "kelp 1", "ball", "stone"]


def test_distances_are_those_from_edges_seen_from_above() -> None:
    wall = Plane(name="wall", position_ned=(90.0, 0.0, 22.0), normal_ned=(1.0, 0.0, 0.0), width_m=40.0, height_m=6.0)
    found = SceneObjects(scene(wall, sphere("ball", 50.0, 3.0)), 1.0)
    places = np.array([[87.0, -15.0], [94.0, 23.0], [50.0, 3.5], [53.0, 7.0]])
    np.testing.assert_allclose(
        found.distances(0.0, places), [[3.0, math.hypot(37.0, 18.0) - 1.0], [5.0, math.hypot(44.0, 20.0) - 1.0],
                                       [40.0, 0.0], [37.0, 4.0]], atol=1e-12
    )  # fmt: skip


def test_height_over_a_slope() -> None:
    bed = Scene(SceneFile(seed=1, vehicle=HERE, sea_bed=SeaBed(depth_m=25.0, slope_deg=10.0))).sea_bed
    assert bed is not None
    # 30 m ahead the plane is 30 tan(10 deg) deeper; the height is normal to it
    deeper = 30.0 * math.tan(math.radians(10.0))
    expected = (5.0 + deeper) * math.cos(math.radians(10.0))
    assert bed.height_over(np.array([30.0, 0.0, 20.0])) == pytest.approx(expected)


def test_an_object_counts_from_a_second_after_it_is_loud_and_only_while_it_is() -> None:
    on, off = (1, lifecycle.ACTIVE, 50.5, 0.5, 1.0), (1, lifecycle.ACTIVE, 56.0, 0.0, 1.0)
    silent = (1, lifecycle.STAND_BY, 50.5, 0.5, 1.0)
    rows: list[Row] = [[], [], [on], [off], [silent], [], [on]]
    lists = lists_of(rows, [3.0, 12.0, 12.0, 12.0, 12.0, 4.0, 11.0])
    (target,) = judge("s", lists, SceneObjects(scene(sphere("ball", 50.0, 0.0)), 1.0)).targets
    assert (target.expected, target.tracked) == (4, 3)
    assert (target.confirmed_s, target.confirmed_m) == (1.0, 50.0)


def test_false_obstacles_are_active_and_mostly_near_nothing() -> None:
    ball, clutter = (1, lifecycle.ACTIVE, 50.0, 0.0, 1.0), (2, lifecycle.ACTIVE, 70.0, 5.0, 1.0)
    large, slept = (3, lifecycle.ACTIVE, 55.0, 0.0, 4.5), (4, lifecycle.HIBERNATED, 20.0, 5.0, 1.0)
    passing = [(5, lifecycle.ACTIVE, north, 0.0, 1.0) for north in (51.0, 51.5, 60.0)]
    rows: list[Row] = [[ball, clutter, large, slept, passing[0]], [ball, clutter, passing[1]], [ball, passing[2]]]
    score = judge("s", lists_of(rows, [20.0] * 3), SceneObjects(scene(sphere("ball", 50.0, 0.0)), 1.0))
    assert score.false_ids == 1
    assert score.false_a_minute == pytest.approx(30.0)
    assert score.false_at_a_time == pytest.approx(2.0 / 3.0)
    assert (score.detections, score.chain_ms, score.tracker_ms) == (3.0, 1.0, 2.0)
    assert scene_table([score]).row_count == 1


def test_a_list_that_is_not_valid_tells_nothing_false() -> None:
    clutter = (2, lifecycle.ACTIVE, 70.0, 5.0, 1.0)
    rows: list[Row] = [[clutter], [clutter], []]
    bodies = SceneObjects(scene(sphere("ball", 50.0, 0.0)), 1.0)
    assert [judge("s", lists_of(rows, [20.0] * 3, unsettled=k), bodies).false_ids for k in (0, 1, 2)] == [1, 1, 0]


def test_the_altitude_is_that_of_the_bed_below() -> None:
    """Against a plane that falls by 10 degrees to the north, from 25 m at the origin."""
    bed = Scene(SceneFile(seed=1, vehicle=HERE, sea_bed=SeaBed(depth_m=25.0, slope_deg=10.0))).sea_bed
    assert bed is not None
    assert bed.altitude_of(np.array([30.0, 4.0, 20.0])) == pytest.approx(5.0 + 30.0 * math.tan(math.radians(10.0)))


def test_what_is_never_found_has_no_range_and_a_group_is_found_by_any_of_it() -> None:
    items = [sphere("school/1", 50.0, 0.0), sphere("school/2", 55.0, 0.0), sphere("ball", 50.0, 20.0)]
    rows: list[Row] = [[(1, lifecycle.ACTIVE, 55.0, 1.0, 1.0)]] * 3
    score: SceneScore = judge("s", lists_of(rows, [15.0] * 3, ("school/1", "ball")), SceneObjects(scene(*items), 1.0))
    ball, school = score.targets
    assert (ball.name, ball.share, school.name, school.share) == ("ball", 0.0, "school", 1.0)
    assert math.isnan(ball.confirmed_m)
    assert score.least_share == 0.0


def test_images_are_kept_and_another_seed_gives_others(tmp_path: Path) -> None:
    file = tmp_path / "s.toml"
    file.write_text("seed = 3\nduration_s = 1.0\n[vehicle]\nposition_ned = [0, 0, 20]\n[sea_bed]\ndepth_m = 24.0\n")
    sonar = load_sonar(CONFIG / "sonars" / "seabat6012.toml")
    fresh = list(images_of(scene_with_seed(file, 0), sonar, 0.3))
    kept = list(images_of(scene_with_seed(file, 0), sonar, 0.3, tmp_path))
    again = list(images_of(scene_with_seed(file, 0), sonar, 0.3, tmp_path))
    other = list(images_of(scene_with_seed(file, 1), sonar, 0.3, tmp_path))
    assert fresh == kept == again
    assert len(fresh) == 3
    assert other[0].ping.data != fresh[0].ping.data
    assert len(list(tmp_path.glob("*.pings"))) == 2


def test_the_family_of_sea_beds() -> None:
    files = shipped_scenes()
    altitudes, speeds = [], []
    for file in files:
        loaded = load_scene(file)
        assert loaded.sea_bed is not None
        altitudes.append(loaded.sea_bed.height_over(loaded.pose_at(0.0).position_ned))
        speeds.append(float(np.linalg.norm(loaded.vehicle_at(0.0).velocity_body)))
        assert SceneObjects(loaded, 1.0).targets
        assert loaded.file.duration_s == 35.0
    rough = {file.stem: load_scene(file).file.sea_bed for file in files}
    asked = {"gentle": (0.05, 3.0), "slope": (0.15, 3.0), "rocky": (0.25, 2.0), "ripples": (0.12, 0.8)}
    for name, (height, length) in asked.items():
        bed = rough[name]
        assert bed is not None
        assert isinstance(bed.rough, Roughness)
        assert (bed.rough.rms_height_m, bed.rough.correlation_m) == (height, length)
    assert len(files) == 10
    assert min(altitudes) > 1.5
    assert max(altitudes) > 9.0
    assert max(speeds) == pytest.approx(2.0)


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "deaf.toml").write_text(
        '[[pipeline.stage]]\nuse = "filter.box"\n[[pipeline.stage]]\nuse = "detect.one_level"\nlevel = 1000.0\n'
    )
    chart = tmp_path / "chart.png"
    asked = ["--scenes", "gentle", "--seconds", "3", "--images", str(tmp_path)]
    assert main(["assess", "sea", *asked, "--out", str(chart)]) == 0
    text = capsys.readouterr().out
    lines = {line.split()[0]: line.split() for line in text.splitlines() if "%" in line}
    assert lines["mover"][-4] == "100.0%"
    assert 8.0 < float(lines["mover"][-1]) < 20.0  # margin, dB
    assert "100%" in lines["from"]  # 10 dB on
    assert chart.stat().st_size > 10_000
    assert main(["assess", "sea", *asked, "--config", str(tmp_path / "deaf.toml")]) == 0
    assert capsys.readouterr().out.count("never") == 6


def test_a_wrong_name_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["assess", "sea", "--scenes", "gentel"]) == 2
    assert "--scenes" in capsys.readouterr().err
    assert main(["assess", "sea", "--images", "/no/such"]) == 2
    assert "no such folder" in capsys.readouterr().err


def test_scenes_of_one_name_in_two_folders_have_two_lines() -> None:
    files = [Path("one/rocky.toml"), Path("one/slope.toml"), Path("two/rocky.toml")]
    assert names_of(files) == ["one/rocky", "slope", "two/rocky"]
