from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.base.settings_file import ConfigError
from ods.sim_sonar.echo.bodies.bodies import BODY, PLANE, SPHERE, UNBOUNDED, Bodies
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.mean_area import Surroundings, mean_area
from ods.sim_sonar.pose import VehiclePose
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.sea_bed.height_field import height_at, load_field, seeded_field
from ods.sim_sonar.sea_bed.model import SeaBedModel, make_sea_bed
from ods.sim_sonar.sonar.grid import grid_of
from ods.sim_sonar.sonar.model import make_sonar
from ods.sim_sonar.sonar.patterns import horizontal_power
from ods.sim_sonar.sonar.settings import SonarFile, VerticalPattern

Heights = Callable[[Floats, Floats], Floats]

SURFACE = Surface(cd=0.5, cs=0.3, sigma_deg=20.0)
PATTERN = VerticalPattern()
SONAR = make_sonar(SonarFile(name="short", frequency_hz=455e3, beams_per_plane=21, beam_spacing_deg=2.0,
                             beam_width_deg=2.0, range0_m=0.1, dr_m=0.1, samples=400))  # fmt: skip
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
NO_CLIENT = np.empty(0, BODY)


def image_of(bed: SeaBedModel, objects: Bodies = NO_CLIENT, attitude: Floats = LEVEL,
             max_error: float = 0.01, shadows: bool = True) -> Floats:  # fmt: skip
    surroundings = Surroundings(objects, bed, shadows)
    return mean_area(grid_of(SONAR), surroundings, VehiclePose(np.zeros(3), attitude), max_error)


def smoothed_error(image: Floats, reference: Floats) -> float:
    return float(np.linalg.norm(uniform_filter(image - reference, (3, 9))) /
                 np.linalg.norm(uniform_filter(reference, (3, 9))))  # fmt: skip


def bed_from(tmp_path: Path, heights: Heights, depth: float, facet: float = 0.25, half: float = 60.0) -> SeaBedModel:
    nodes = np.arange(-half, half + facet / 2, facet)
    path = tmp_path / f"bed{facet}.npz"
    np.savez(path, height_m=heights(nodes[:, None], nodes[None, :]), facet_m=facet, north_m=-half, east_m=-half)
    return make_sea_bed(depth, SURFACE, load_field(path))


def dunes(north: Floats, east: Floats) -> Floats:
    return np.asarray(0.35 * np.sin(0.7 * north + 0.3 * east) + 0.2 * np.cos(0.5 * east - 0.2 * north + 1.0))


def sphere(north: float, east: float, down: float, radius: float) -> Bodies:
    return np.array([(SPHERE, (north, east, down), np.eye(3), (radius, radius, radius), 0.4, 0.1, 0.3)], BODY)


def summed_over_the_ground(heights: Heights, depth: float, attitude: Floats) -> Floats:
    """Eq. 5 as a plain sum over small areas of ground, each seen if nothing on the straight line to it is higher."""
    step, turn = 0.03, np.radians(0.3)
    away = np.arange(step / 2, 41.0, step)
    toward = np.arange(-0.75, 0.75, turn)
    north, east = away[:, None] * np.cos(toward), away[:, None] * np.sin(toward)
    ground = np.stack([north, east, depth - heights(north, east)], axis=-1)
    distance, bearing, elevation = geometry.body_to_polar(geometry.global_to_body(ground, np.zeros(3), attitude))
    steep = -ground[..., 2] / away[:, None]
    seen = steep >= np.maximum.accumulate(steep, axis=0)
    slopes = np.stack(
        [
            (heights(north + 1e-4, east) - heights(north - 1e-4, east)) / 2e-4,
            (heights(north, east + 1e-4) - heights(north, east - 1e-4)) / 2e-4,
            np.ones_like(north),
        ],
        axis=-1,
    )
    slopes[..., :2] *= -1.0  # the upward normal, times sqrt(1 + slope^2)
    facing = -np.sum(slopes * ground * [1.0, 1.0, -1.0], axis=-1) / distance
    length = np.linalg.norm(slopes, axis=-1)
    cosine = np.clip(facing / length, 1e-6, 1.0)
    lobe = np.exp(-np.square(np.degrees(np.arccos(cosine)) / SURFACE.sigma_deg) / 2.0)
    gamma = SURFACE.cd * cosine + SURFACE.cs * np.minimum(1.0, 2.0 * cosine**2) * lobe / cosine  # eqs. 3 and 4
    two_way = 10 ** (np.interp(np.degrees(np.abs(elevation)), PATTERN.angle_deg, PATTERN.level_db) / 10)
    echo = np.where(seen, gamma * np.maximum(facing, 0.0) * two_way * away[:, None] * step * turn, 0.0)
    offsets = np.linspace(-120.0, 120.0, 24001)
    powers = horizontal_power(offsets, -25.0)
    rows = []
    for axis in SONAR.bearing_rad:
        received = echo * np.interp((bearing - axis) / SONAR.beam_width_rad, offsets, powers)
        rows.append(np.histogram(distance, 0.05 + 0.1 * np.arange(401), weights=received)[0])
    return np.array(rows)


def test_rough_bed_is_the_sum_over_its_visible_ground(tmp_path: Path) -> None:
    bed = bed_from(tmp_path, dunes, 3.0, facet=0.1)
    for attitude in (LEVEL, geometry.quat_from_euler(0.06, -0.05, 0.0)):
        expected = summed_over_the_ground(dunes, 3.0, attitude)[2:-2]
        image = image_of(bed, attitude=attitude)[2:-2]
        assert smoothed_error(image, expected) < 0.02
        assert image.sum() == pytest.approx(expected.sum(), rel=0.01)


def test_tilted_flat_bed_is_the_sum_over_its_ground() -> None:
    attitude = geometry.quat_from_euler(0.3, -0.15, 0.0)
    expected = summed_over_the_ground(lambda n, e: 0.0 * n * e, 3.0, attitude)[2:-2]
    assert smoothed_error(image_of(make_sea_bed(3.0, SURFACE), attitude=attitude)[2:-2], expected) < 0.02


def test_beyond_its_border_a_file_of_heights_goes_on_even(tmp_path: Path) -> None:
    bed = bed_from(tmp_path, lambda n, e: -0.1 * n + 0.1 * dunes(n, e), 3.0, facet=0.1, half=12.0)
    image = image_of(bed)[2:-2]

    def goes_on(north: Floats, east: Floats) -> Floats:
        n, e = np.clip(north, -12.0, 12.0), np.clip(east, -12.0, 12.0)
        return -0.1 * n + 0.1 * dunes(n, e)

    expected = summed_over_the_ground(goes_on, 3.0, LEVEL)[2:-2]
    assert smoothed_error(image, expected) < 0.02
    beyond = slice(180, 400)
    assert image[:, beyond].sum() == pytest.approx(expected[:, beyond].sum(), rel=0.03)


@pytest.mark.parametrize("slope_deg", [0.0, 4.0])
def test_heights_of_nothing_are_the_flat_bed_in_closed_form(slope_deg: float) -> None:
    attitude = geometry.quat_from_euler(0.03, 0.04, 0.5)
    slope = (np.radians(slope_deg), 1.0)
    almost = make_sea_bed(3.0, SURFACE, seeded_field(1, 1e-6, 3.0, 64, None), *slope)
    flat, rough = make_sea_bed(3.0, SURFACE, None, *slope), image_of(almost, attitude=attitude, max_error=0.005)
    assert almost.field is not None
    assert smoothed_error(rough, image_of(flat, attitude=attitude)) < 0.01
    assert make_sea_bed(3.0, SURFACE, seeded_field(1, 0.0, 3.0, 64, None)).field is None


def test_energy_does_not_depend_on_the_number_of_facets(tmp_path: Path) -> None:
    few, many = (image_of(bed_from(tmp_path, dunes, 3.0, facet), max_error=0.005) for facet in (0.25, 0.1))
    assert few.sum() == pytest.approx(many.sum(), rel=0.015)
    assert smoothed_error(few, many) < 0.03


def test_left_and_right_are_alike(tmp_path: Path) -> None:
    one = image_of(bed_from(tmp_path, dunes, 3.0), sphere(15.0, 3.0, 2.5, 0.8))
    other = image_of(bed_from(tmp_path, lambda n, e: dunes(n, -e), 3.0), sphere(15.0, -3.0, 2.5, 0.8))
    np.testing.assert_allclose(other[::-1], one, rtol=1e-3, atol=4e-4 * one.max())


def test_shadow_of_a_sphere_ends_where_similar_triangles_say() -> None:
    bed = make_sea_bed(4.0, SURFACE, seeded_field(1, 1e-6, 3.0, 64, None))
    flat = make_sea_bed(4.0, SURFACE)
    radius, ahead, down = 0.8, 12.0, 3.2
    upper = np.arctan2(down, ahead) - np.arcsin(
        radius / np.hypot(ahead, down)
    )  # below the horizon: the tangent's angle
    end = 4.0 / np.sin(upper)
    for one in (bed, flat):
        open_, hidden = image_of(one), image_of(one, sphere(ahead, 0.0, down, radius))
        ratio = (hidden / np.maximum(open_, 1e-12))[10]
        ranges = SONAR.range0_m + SONAR.dr_m * np.arange(400)
        behind = (ranges > np.hypot(ahead, down) + 0.6) & (ranges < 0.93 * end)
        assert ratio[behind].max() < 0.1
        assert ratio[ranges > end + 0.3].min() > 0.97
        np.testing.assert_allclose(image_of(one, sphere(ahead, 0.0, down, radius), shadows=False).min(), open_.min())


def test_ridge_hides_what_stands_behind_it(tmp_path: Path) -> None:
    def ridge(north: Floats, east: Floats) -> Floats:
        return np.asarray(3.0 * np.exp(-np.square((north - 18.0) / 1.5)) + 0.0 * east)

    bed = bed_from(tmp_path, ridge, 4.0)
    behind, above = sphere(26.0, 0.0, 3.2, 0.7), sphere(26.0, 0.0, -1.0, 0.7)
    np.testing.assert_allclose(image_of(bed, behind), image_of(bed), atol=1e-12)
    assert image_of(bed, above).sum() > image_of(bed).sum() + 0.1
    assert image_of(bed)[10, 230:280].max() < 0.02 * image_of(bed)[10].max()


def test_seeded_heights_have_the_asked_statistics() -> None:
    field = seeded_field(7, 0.4, 4.0, 512, 1.0)
    height = field.nodes[:-1, :-1, 0].astype(np.float64)
    assert height.std() == pytest.approx(0.4, rel=1e-4)
    assert abs(height.mean()) < 1e-5
    along = np.mean(height * np.roll(height, 4, axis=0)) / 0.16
    across = np.mean(height * np.roll(height, 4, axis=1)) / 0.16
    assert [along, across] == pytest.approx([np.exp(-1.0)] * 2, abs=0.05)
    assert field.nodes[..., 1].std() == pytest.approx(np.sqrt(2.0) * 0.4 / 4.0, rel=0.1)
    assert field.scale_m == pytest.approx(4.0, rel=0.1)
    assert height_at(field, 3.3, 5.1) == pytest.approx(height_at(field, 3.3 - 512.0, 5.1 + 1024.0), abs=1e-5)
    assert np.array_equal(field.nodes, seeded_field(7, 0.4, 4.0, 512, 1.0).nodes)
    assert not np.array_equal(field.nodes, seeded_field(8, 0.4, 4.0, 512, 1.0).nodes)


def test_million_facets_are_an_image_and_too_many_an_error(tmp_path: Path) -> None:
    image = image_of(bed_from(tmp_path, dunes, 3.0, facet=0.12, half=60.0), max_error=0.03)
    assert np.all(np.isfinite(image))
    assert image.sum() == pytest.approx(image_of(bed_from(tmp_path, dunes, 3.0, facet=0.3)).sum(), rel=0.03)
    path = tmp_path / "huge.npz"
    np.savez_compressed(path, height_m=np.zeros((2100, 2100)), facet_m=1.0, north_m=0.0, east_m=0.0)
    with pytest.raises(ValueError, match=r"huge\.npz: more than 4000000 facets"):
        load_field(path)


GOOD: dict[str, Any] = {"height_m": np.zeros((4, 5)), "facet_m": 1.0, "north_m": 0.0, "east_m": 0.0}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"height_m": np.full((4, 5), np.nan)}, "finite"),
        ({"height_m": np.zeros(5)}, "at least 2 x 2"),
        ({"facet_m": 0.0}, "facet_m above 0"),
        ({"facet_m": [1.0, 2.0]}, "must hold"),
        ({"height_m": None}, "must hold"),
        ({"height_m": np.array([["a", "b"], ["c", "d"]])}, "must hold numbers"),
    ],
)
def test_bad_height_files_are_one_line(tmp_path: Path, change: dict[str, Any], said: str) -> None:
    content = {key: value for key, value in {**GOOD, **change}.items() if value is not None}
    np.savez(tmp_path / "bed.npz", **content)
    scene = tmp_path / "scene.toml"
    scene.write_text('seed = 1\n[vehicle]\nposition_ned = [0, 0, 0]\n[sea_bed]\ndepth_m = 9\nfile = "bed.npz"\n')
    with pytest.raises(ConfigError, match=said) as caught:
        load_scene(scene)
    assert "\n" not in str(caught.value)
    (tmp_path / "bed.npz").write_text("not an archive")
    with pytest.raises(ConfigError, match=r"not a complete \.npz file"):
        load_scene(scene)
    (tmp_path / "bed.npz").unlink()
    with pytest.raises(ConfigError, match="No such file"):
        load_scene(scene)


def test_vehicle_in_a_hill_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "bed.npz", height_m=np.full((4, 5), 3.0) + np.eye(4, 5), facet_m=1.0, north_m=0.0, east_m=0.0)
    scene = tmp_path / "scene.toml"
    scene.write_text('seed = 1\n[vehicle]\nposition_ned = [0, 0, 7]\n[sea_bed]\ndepth_m = 9\nfile = "bed.npz"\n')
    with pytest.raises(ConfigError, match=r"below the sea-bed at t = 0\.00 s"):
        load_scene(scene)


def test_quay_stands_on_a_rough_bed_and_ends_the_view(tmp_path: Path) -> None:
    bed = bed_from(tmp_path, dunes, 3.0)
    facing = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    endless = (UNBOUNDED, UNBOUNDED, 0.0)
    quay = np.array([(PLANE, (25.0, 0.0, 0.0), facing, endless, 0.3, 0.4, 0.3)], BODY)
    image, bare = image_of(bed, quay), image_of(bed)
    np.testing.assert_allclose(image[10, :240], bare[10, :240], rtol=0.05, atol=1e-3 * bare[10].max())
    assert image[10, 249] > 5.0 * bare[10, 249]
    assert image[10, 300:].max() < 0.05 * bare[10, 300:].max()
