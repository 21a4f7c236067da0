from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from benchmarks.simulator.budget import HERE as LEVEL, SEABAT as SEABAT_FILE, error_of, scene_of, summed
from ods.base.arrays import Floats
from ods.sim_sonar.echo.bodies.bodies import BODY, CYLINDER, PLANE, SPHERE
from ods.sim_sonar.echo.rays.detail import LEVEL_ERRORS
from ods.sim_sonar.echo.rays.ray_budget import ray_fan_of
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.mean_area import Surroundings, mean_area
from ods.sim_sonar.pose import VehiclePose
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.sea_bed.model import make_sea_bed
from ods.sim_sonar.sonar.grid import grid_of
from ods.sim_sonar.sonar.model import load_sonar, make_sonar
from ods.sim_sonar.sonar.settings import SonarFile

CONFIG = Path(__file__).parents[2] / "config"
SEABAT = load_sonar(CONFIG / "sonars/seabat6012.toml")
SCENES = ("flat_bottom", "figure11", "rough_figure11", "rough_50")


def area(scene: Scene, max_error: float) -> Floats:
    return mean_area(grid_of(SEABAT), Surroundings(scene.bodies_at(3.0), scene.sea_bed), scene.pose_at(3.0), max_error)


@cache
def reference(name: str) -> Floats:
    return area(load_scene(CONFIG / f"scenes/{name}.toml"), LEVEL_ERRORS[-1])


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("max_error", [0.12, 0.06, 0.03])
def test_mean_image_keeps_its_budget(name: str, max_error: float) -> None:
    image = area(load_scene(CONFIG / f"scenes/{name}.toml"), max_error)
    off, whole = uniform_filter(image - reference(name), (3, 9)), uniform_filter(reference(name), (3, 9))
    assert np.linalg.norm(off) < max_error * np.linalg.norm(whole)
    assert image.sum() == pytest.approx(reference(name).sum(), rel=max_error)


def test_same_input_same_bytes() -> None:
    scene = load_scene(CONFIG / "scenes/rough_figure11.toml")
    assert area(scene, 0.03).tobytes() == area(load_scene(CONFIG / "scenes/rough_figure11.toml"), 0.03).tobytes()


def test_levels_run_from_coarse_to_the_reference() -> None:
    assert list(LEVEL_ERRORS) == sorted(LEVEL_ERRORS, reverse=True)


def test_what_lies_outside_the_fan_changes_nothing() -> None:
    places = [(-20.0, 0.0, 0.0), (-5.0, 40.0, 1.0), (150.0, 0.0, 0.0), (110.0, 40.0, 2.0)]
    objects = np.array([(SPHERE, place, np.eye(3), (2.0, 2.0, 2.0), 0.5, 0.2, 0.3) for place in places], BODY)
    pose, grid = VehiclePose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])), grid_of(SEABAT)
    for sea_bed in (None, make_sea_bed(5.0, Surface())):
        empty = mean_area(grid, Surroundings(objects[:0], sea_bed), pose)
        assert np.array_equal(mean_area(grid, Surroundings(objects, sea_bed), pose), empty)


def test_random_objects_are_the_sum_over_their_surfaces() -> None:
    file = SonarFile(name="short", frequency_hz=455e3, beams_per_plane=31, beam_spacing_deg=2.0, beam_width_deg=2.0,
                     range0_m=0.1, dr_m=0.1, samples=420)  # fmt: skip
    errors = []
    for seed in range(40):
        bodies = scene_of((SPHERE, CYLINDER, PLANE)[seed % 3], seed, farthest_m=38.0)
        errors.append(error_of(bodies, summed(bodies, file, step_m=0.08), make_sonar(file), 0.03))
    assert np.mean(np.array(errors) < 0.03) >= 0.97
    assert max(errors) < 0.05


@pytest.mark.parametrize("beyond_deg", [10.0, 25.0])
def test_side_lobes_hear_what_stands_beyond_the_last_beam(beyond_deg: float) -> None:
    bearing = SEABAT.bearing_rad[-1] + np.radians(beyond_deg)
    place = (30.0 * np.cos(bearing), 30.0 * np.sin(bearing), 0.0)
    bodies = np.array([(SPHERE, place, np.eye(3), (1.0, 1.0, 1.0), 0.5, 0.5, 0.3)], BODY)
    image, expected = mean_area(grid_of(SEABAT), Surroundings(bodies), LEVEL), summed(bodies, SEABAT_FILE)
    assert 20000.0 * np.sqrt(expected.max()) > 25.0
    off, whole = uniform_filter(image - expected, (3, 9)), uniform_filter(expected, (3, 9))
    assert np.linalg.norm(off) < 0.03 * np.linalg.norm(whole)


def test_upright_planes_have_no_column_between_their_upper_and_lower_corners() -> None:
    grid = grid_of(SEABAT)
    for degrees in np.linspace(-20.0, 20.0, 60):
        turn = np.radians(degrees)
        axes = np.array([[np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0], [np.cos(turn), -np.sin(turn), 0.0]])
        wall = np.array([(PLANE, (40.0, 3.0, 2.0), axes, (11.0, 5.0, 0.0), 0.5, 0.5, 0.3)], BODY)
        assert np.diff(ray_fan_of(wall, 0, grid, 0.03).bearing).min() > 1e-9


@pytest.mark.parametrize("lean", [0.1, 0.2, 0.4])
@pytest.mark.parametrize("range_m", [20.0, 35.0])
def test_nothing_is_drawn_before_the_nearest_point_of_a_body(lean: float, range_m: float) -> None:
    """Of the upper end of a cylinder that leans towards the sonar an echo was, up to 0.8 m before its rim."""
    file = SonarFile(name="short", frequency_hz=455e3, beams_per_plane=31, beam_spacing_deg=2.0, beam_width_deg=2.0,
                     range0_m=0.05, dr_m=0.05, samples=800)  # fmt: skip
    axis = np.array([lean, 0.5 * lean, 1.0]) / np.linalg.norm([lean, 0.5 * lean, 1.0])
    axes = np.linalg.qr(np.array([axis, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).T)[0].T[[1, 2, 0]]
    body = (CYLINDER, (range_m * 0.9, -range_m * 0.43, 0.6), axes, (2.0, 2.0, 2.5), 0.1, 0.05, np.radians(15.0))
    bodies = np.array([body], BODY)
    drawn = mean_area(grid_of(make_sonar(file)), Surroundings(bodies, None), LEVEL)
    assert _sets_in(drawn) >= _sets_in(summed(bodies, file)) - 2


def _sets_in(image: Floats) -> int:
    """Return the first sample at which a beam receives a thousandth of the image's peak."""
    return int(np.flatnonzero(image.max(axis=0) > 1e-3 * image.max())[0])
