from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from ods.base.arrays import Floats
from ods.sim_sonar.echo.bodies import BODY, SPHERE
from ods.sim_sonar.echo.detail import LEVEL_ERRORS
from ods.sim_sonar.echo.settings import Surface
from ods.sim_sonar.mean_area import Surroundings, mean_area
from ods.sim_sonar.pose import VehiclePose
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.sea_bed.model import make_sea_bed
from ods.sim_sonar.sonar.grid import grid_of
from ods.sim_sonar.sonar.model import load_sonar

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
    places = [(-20.0, 0.0, 0.0), (0.0, 40.0, 1.0), (150.0, 0.0, 0.0), (110.0, 40.0, 2.0)]
    objects = np.array([(SPHERE, place, np.eye(3), (2.0, 2.0, 2.0), 0.5, 0.2, 0.3) for place in places], BODY)
    pose, grid = VehiclePose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])), grid_of(SEABAT)
    for sea_bed in (None, make_sea_bed(5.0, Surface())):
        empty = mean_area(grid, Surroundings(objects[:0], sea_bed), pose)
        assert np.array_equal(mean_area(grid, Surroundings(objects, sea_bed), pose), empty)
