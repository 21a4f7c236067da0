"""The simulator's menu against the simulator itself."""

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from ods.base.files.shipped import shipped_file
from ods.offline.mission import Mission, MissionSettings
from ods.offline.run_record import RunRecord
from ods.offline.score import score_objects
from ods.offline.source import open_source
from ods.plots.polar import level_db
from ods.sim_sonar.by_name import find_scene, find_sonar
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.shots import shot_at
from ods.workbench.engine.scene.curves import beam_pattern, reflection, vertical_pattern
from ods.workbench.engine.scene.pictures import ScenePictures
from ods.workbench.engine.scene.plan import plan_of, strip_of
from ods.workbench.engine.scene.rehearsal import rehearse
from ods.workbench.engine.scene.view import Asked, SceneError, built
from ods.workbench.model.paths import with_value
from tests.workbench.engine.test_own_process import keeping

SONAR = find_sonar("seabat6012")
FIGURE_11 = find_scene("figure11_imperfect").file
replace = msgspec.structs.replace


def seen(pictures: ScenePictures, file: SceneFile, ping: int = 4) -> np.ndarray:
    return pictures.picture(Asked(file, "seabat6012", ping)).level_db


def test_pictures_are_those_of_the_simulator_whatever_was_edited_before() -> None:
    pictures = ScenePictures()
    edits = [
        FIGURE_11,
        with_value(FIGURE_11, "objects[0].position_ned", [30.0, 5.0, 21.0]),
        with_value(FIGURE_11, "image.dropouts", []),
        replace(FIGURE_11, seed=3),
        FIGURE_11,
    ]
    for file in edits:
        shot = shot_at(ImageSimulator(SONAR, Scene(file)), 4)
        assert np.array_equal(seen(pictures, file), level_db(shot.ping))
        assert pictures.picture(Asked(file, "seabat6012", 4)).truth == shot.truth.objects


def test_after_the_last_ping_the_last_one_stays() -> None:
    pictures = ScenePictures()
    last = int(FIGURE_11.duration_s / SONAR.ping_period_s)
    assert pictures.picture(Asked(FIGURE_11, "seabat6012", 99_999)).ping.ping_number == last


def test_expected_levels_are_the_mean_of_what_is_sent() -> None:
    """Over thousands of samples the power sent comes to what is expected."""
    pictures = ScenePictures()
    clean = find_scene("figure11").file
    first = pictures.picture(Asked(clean, "seabat6012", 0))
    assert np.array_equal(first.expected_db, first.perfect_db)
    power = 10.0 ** (0.1 * first.level_db)
    expected = 10.0 ** (0.1 * first.expected_db)
    assert np.mean(power / expected) == pytest.approx(1.0, abs=0.02)


def test_belts_and_drop_outs_stand_between_expected_and_perfect() -> None:
    shown = ScenePictures().picture(Asked(replace(FIGURE_11, image=replace(FIGURE_11.image, beam_gain_rms_db=0.0,
        interference=[])), "seabat6012", 4))  # fmt: skip
    ranges = SONAR.range0_m + SONAR.dr_m * np.arange(SONAR.samples)
    difference = (shown.expected_db - shown.perfect_db)[30]
    for at_m, gain_db in ((40.0, 0.0), (55.0, -5.0), (75.0, 4.0), (78.0, 4.0 - 20.0), (82.0, -20.0)):
        assert difference[np.abs(ranges - at_m).argmin()] == pytest.approx(gain_db, abs=0.01)


def test_a_scene_that_cannot_be_is_one_line() -> None:
    pictures = ScenePictures()
    for file in (
        with_value(FIGURE_11, "sea_bed.depth_m", 19.0),
        with_value(FIGURE_11, "objects[0].position_ned", [0.0, 0.0, 20.0]),
        with_value(with_value(FIGURE_11, "image.beam_gain_rms_db", 0.0), "image.beam_gain_db", [1.0, 2.0]),
        with_value(FIGURE_11, "sea_bed", {"depth_m": 23.1, "file": "nowhere/heights.npz"}),
    ):
        with pytest.raises(SceneError) as caught:
            seen(pictures, file)
        assert "\n" not in str(caught.value)
    assert seen(pictures, FIGURE_11).shape == (60, SONAR.samples)


def test_the_vertical_pattern_is_the_shipped_figure_8() -> None:
    """config/sonars/seabat6012.toml: S^2 -6 dB at 10 degrees, so S -3 dB there."""
    (curve,) = vertical_pattern(SONAR)
    at = dict(zip(np.round(curve.x, 1), curve.y, strict=True))
    assert (at[0.0], at[10.0], at[-10.0]) == pytest.approx((0.0, -3.0, -3.0), abs=0.05)
    assert max(level for angle, level in at.items() if abs(angle) > 15.0) < -12.0


def test_the_beam_pattern_is_half_power_at_its_width_and_has_no_lobe_above_what_is_reported() -> None:
    curve = beam_pattern(SONAR)
    half = 0.5 * math.degrees(SONAR.beam_width_rad)
    assert np.interp(half, curve.x, curve.y) == pytest.approx(-3.0, abs=0.1)
    assert np.interp(0.0, curve.x, curve.y) == pytest.approx(0.0, abs=0.01)
    assert curve.y[np.abs(curve.x) > 3.0 * half].max() == pytest.approx(-25.0, abs=0.5)


def test_reflection_is_equation_3() -> None:
    surface = Surface(cd=0.5, cs=0.2, sigma_deg=20.0)
    curve = reflection(surface)
    assert curve.y[0] == pytest.approx(0.7)
    alpha = math.radians(60.0)
    expected = 0.5 * 0.5 + 0.2 * 0.5 * math.exp(-(60.0**2) / (2.0 * 20.0**2)) / math.cos(alpha)
    assert np.interp(60.0, curve.x, curve.y) == pytest.approx(expected)


def test_outlines_are_as_large_as_the_objects() -> None:
    plan = plan_of(Scene(FIGURE_11), SONAR, 2.0)
    sizes = {outline.name: np.ptp(outline.edge, axis=0) for outline in plan.outlines}
    assert sizes["near"] == pytest.approx([3.0, 3.0])
    cos_tilt = 1.0 / math.sqrt(1.0 + 0.04 + 0.01)
    tip_north, tip_east = 5.0 * 0.2 * cos_tilt, 5.0 * 0.1 * cos_tilt
    rim = [4.0 * math.sqrt(1.0 - (part * cos_tilt) ** 2) for part in (0.2, 0.1)]
    assert sizes["port"] == pytest.approx([tip_north + rim[0], tip_east + rim[1]], rel=0.01)
    assert plan.outlines[0].edge.mean(axis=0) == pytest.approx([35.0, 0.0], abs=0.1)


def test_an_upright_sheet_is_a_line_from_above() -> None:
    sheet = {
        "shape": "plane",
        "name": "s",
        "position_ned": [40, 3, 20],
        "normal_ned": [1, 0, 0],
        "width_m": 8,
        "height_m": 2,
    }
    scene = Scene(with_value(FIGURE_11, "objects", [sheet]))
    (outline,) = plan_of(scene, SONAR, 0.0).outlines
    assert sorted(map(tuple, outline.edge.tolist())) == [pytest.approx((40.0, -1.0)), pytest.approx((40.0, 7.0))]


def test_paths_are_of_the_vehicle_and_of_what_moves() -> None:
    plan = plan_of(find_scene("worked_example"), SONAR, 80.0)
    assert set(plan.paths) == {"vehicle", "objects[0]", "objects[1]"}
    assert plan.paths["vehicle"][[0, -1]].tolist() == [[0.0, 0.0], [50.0, 0.0]]
    assert plan.paths["objects[0]"][-1] == pytest.approx([75.7 - 56.0, 5.0 + 32.0])
    assert plan.vehicle == pytest.approx((50.0, 0.0, 0.0))
    assert set(plan_of(Scene(FIGURE_11), SONAR, 0.0).paths) == {"vehicle"}


SHORT = replace(find_scene("figure11").file, duration_s=4.0)


def test_a_rehearsal_is_what_track_makes_of_the_scene(tmp_path: Path) -> None:
    text = shipped_file("scenes/figure11.toml").read_text().replace("duration_s = 60.0", "duration_s = 4.0")
    (tmp_path / "scene.toml").write_text(text)
    source, record = open_source(tmp_path / "scene.toml", sonar="seabat6012"), RunRecord()
    for step in Mission(MissionSettings()).steps(source.pings, source.poses):
        record.lists.append((step.list.made_ns, step.list))
    record.truths = dict(source.truths)
    objects, false_ids = score_objects(record, 3.0)
    shares: list[float] = []
    made = rehearse(Scene(SHORT), SONAR, MissionSettings(), keeping(shares))
    assert made is not None
    assert made.objects == objects
    assert objects
    assert made.false_tracks == len(false_ids)
    assert [reported for _, reported in made.record.lists] == [reported for _, reported in record.lists]
    assert len(shares) == len(source.pings)
    assert shares[-1] == 1.0
    assert shares == sorted(shares)
    assert made.truths == list(source.truths.values())


def test_a_rehearsal_can_be_given_up() -> None:
    shares: list[float] = []
    assert rehearse(Scene(SHORT), SONAR, MissionSettings(), keeping(shares, most=2)) is None
    assert len(shares) == 2


def test_levels_that_do_not_fit_the_sonar_are_reported_of_a_rehearsal_too() -> None:
    file = with_value(SHORT, "image.beam_gain_db", [1.0, 2.0])
    with pytest.raises(SceneError, match="beam_gain_db"):
        rehearse(built(file), SONAR, MissionSettings())


def test_circles_of_the_truth_lie_where_the_objects_are() -> None:
    """Figure 11 at t = 0: the sonar is at the origin, 20 m deep, and looks north."""
    shown = ScenePictures().picture(Asked(FIGURE_11, "seabat6012", 0))
    circles = {item.name: circle for item, circle in zip(shown.truth, shown.truth_circles(), strict=True)}
    assert circles["near"] == pytest.approx((math.hypot(35.0, 1.6), 0.0, 1.5))
    assert circles["port"][:2] == pytest.approx((math.hypot(60.0, 30.0, 0.6), math.atan2(-30.0, 60.0)))


def test_a_profile_keeps_the_highest_of_what_it_leaves_out() -> None:
    shown = ScenePictures().picture(Asked(FIGURE_11, "seabat6012", 0))
    sent, _, perfect = shown.profile(30)
    assert len(sent.x) <= 500
    assert sent.y.max() == shown.level_db[30].max()
    around = (perfect.x > 30.0) & (perfect.x < 40.0)
    assert perfect.x[around][perfect.y[around].argmax()] == pytest.approx(33.6, abs=0.5)


def test_the_strip_tells_depth_and_speed() -> None:
    depth, speed = strip_of(find_scene("worked_example").file, "objects[0]")
    assert depth.y[[0, -1]] == pytest.approx([0.0, 8.0])
    assert speed.y == pytest.approx(np.full(len(speed.y), math.hypot(0.7, 0.4, 0.1)))
    assert strip_of(find_scene("worked_example").file, "vehicle")[1].y == pytest.approx(np.full(121, 50.0 / 80.0))
