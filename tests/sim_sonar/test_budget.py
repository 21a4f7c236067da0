from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from ods.base.arrays import Floats
from ods.sim_sonar.echo import bodies
from ods.sim_sonar.echo.detail import levels
from ods.sim_sonar.echo.settings import Surface
from ods.sim_sonar.mean_area import mean_area
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.sea_bed.model import make_bed
from ods.sim_sonar.sonar.grid import grid_of
from ods.sim_sonar.sonar.model import load_sonar

CONFIG = Path(__file__).parents[2] / "config"
SEABAT = load_sonar(CONFIG / "sonars/seabat6012.toml")
SCENES = ("flat_bottom", "figure11", "rough_figure11", "rough_50")


def area(scene: Scene, max_error: float) -> Floats:
    vehicle = scene.vehicle_at(3.0)
    return mean_area(grid_of(SEABAT), scene.bodies_at(3.0), scene.sea_bed, vehicle.position_ned, vehicle.attitude,
                     max_error=max_error)  # fmt: skip


@cache
def reference(name: str) -> Floats:
    return area(load_scene(CONFIG / f"scenes/{name}.toml"), levels()[-1])


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
    assert list(levels()) == sorted(levels(), reverse=True)


def test_what_lies_outside_the_fan_changes_nothing() -> None:
    rows = np.zeros((4, bodies.COLUMNS))
    rows[:, bodies.KIND] = bodies.SPHERE
    rows[:, bodies.AXES : bodies.HALF] = np.eye(3).ravel()
    rows[:, bodies.HALF : bodies.SURFACE] = 2.0
    rows[:, bodies.SURFACE :] = 0.5, 0.2, 0.3
    rows[:, 1:4] = [[-20.0, 0.0, 0.0], [0.0, 40.0, 1.0], [150.0, 0.0, 0.0], [110.0, 40.0, 2.0]]
    level, origin = np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)
    bed = make_bed(5.0, Surface())
    for sea_bed in (None, bed):
        empty = mean_area(grid_of(SEABAT), rows[:0], sea_bed, origin, level)
        assert np.array_equal(mean_area(grid_of(SEABAT), rows, sea_bed, origin, level), empty)
