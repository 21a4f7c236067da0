"""Compilation ahead of the first image: numba compiles all that images of scenes, whatever they say, may need."""

from collections.abc import Iterator
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import msgspec
import numpy as np

from ods.sim_sonar.image import ImageSimulator, render_image
from ods.sim_sonar.mean_area import Surroundings
from ods.sim_sonar.pose import Transmission
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.shots import shot_at
from ods.sim_sonar.sonar.model import SonarModel, make_sonar
from ods.sim_sonar.sonar.settings import SonarFile

PINGS = 3
"""Of each scene: what a ping finds of the one before it is other code than the first."""
_OBJECTS: list[dict[str, Any]] = [
    {"shape": "sphere", "name": "ball", "position_ned": [12.0, 1.0, 5.0], "radius_m": 1.0},
    {"shape": "sphere", "name": "goes", "radius_m": 0.5, "position_ned": [9.0, -2.0, 4.0], "velocity_ned": [0, 1, 0]},
    {"shape": "cylinder", "name": "post", "position_ned": [15.0, -3.0, 5.0], "radius_m": 0.5, "length_m": 3.0},
    {"shape": "plane", "name": "hatch", "position_ned": [18.0, 3.0, 4.0], "normal_ned": [1, 0, 0],
     "width_m": 2.0, "height_m": 2.0},
    {"shape": "plane", "name": "wall", "position_ned": [22.0, 0.0, 4.0], "normal_ned": [1, 0.2, 0]},
]  # fmt: skip
_IMPERFECT: dict[str, Any] = {
    "range_correlation": 0.2,
    "coherence_s": 1.0,
    "beam_gain_rms_db": 0.5,
    "tvg": {"noise_range_m": 10.0},
    "belts": [{"from_m": 5.0, "to_m": 6.0, "gain_db": -5.0}],
    "dropouts": [{"range_m": 8.0}],
    "drop_ins": [{"width_m": 0.4}],
    "interference": [{"position_ned": [20.0, 5.0, 5.0], "level_counts": 1e4}],
}
_LEVELS: tuple[dict[str, Any], ...] = (
    _IMPERFECT, {"looks": 2.5, "samples": "linear8"}, {"speckle": False, "samples": "linear16"},
)  # fmt: skip
_PLANES = ((0.0,), (-20.0, 0.0, 20.0))


def warm_up() -> None:
    """Let small sonars look at scenes with all shapes, sea-beds and effects that there are."""
    with TemporaryDirectory() as folder:
        scenes = [Scene(file) for file in _scenes(Path(folder))]
        for planes in _PLANES:
            sonar = _sonar(planes)
            images = ImageSimulator(sonar, scenes[0])
            for scene in scenes:
                _look(images.seeing(scene))
            for levels in _LEVELS:
                image = msgspec.convert(levels, ImageLevels)
                _look(ImageSimulator(sonar, Scene(msgspec.structs.replace(scenes[-1].file, image=image))))
        seen = Surroundings(scene.bodies_at(0.0), scene.sea_bed)
        render_image(sonar, seen, Transmission(scene.head_at(0.0)))


def _look(images: ImageSimulator) -> None:
    for number in range(PINGS):
        shot_at(images, number)
        images.mean_image(number * images.sonar.ping_period_s, number)


def _scenes(folder: Path) -> Iterator[SceneFile]:
    """Yield scenes with every kind of sea-bed, with and without objects. folder: gets a file of heights."""
    file = folder / "heights.npz"
    height = np.random.default_rng(0).normal(0.0, 0.1, (64, 64))
    np.savez(file, height_m=height, facet_m=1.0, north_m=-5.0, east_m=-32.0)
    rough = {"rms_height_m": 0.1, "correlation_m": 1.0, "facets": 64}
    beds: tuple[dict[str, Any] | None, ...] = (
        {"file": file}, {"rough": rough}, {"rough": rough, "slope_deg": 5.0}, None, {}, {"slope_deg": 5.0},
    )  # fmt: skip
    for bed, objects, shadows in product(beds, ([], _OBJECTS), (True, False)):
        tables = {
            "seed": 1, "duration_s": 1.0, "shadows": shadows, "objects": objects,
            "vehicle": {"position_ned": [0, 0, 4], "velocity_ned": [0.5, 0, 0], "yaw": {"amplitude_deg": 3.0}},
            "sea_bed": None if bed is None else {"depth_m": 8.0, **bed},
        }  # fmt: skip
        yield msgspec.convert(tables, SceneFile)


def _sonar(planes: tuple[float, ...]) -> SonarModel:
    return make_sonar(
        SonarFile(
            name="small", frequency_hz=455000.0, beams_per_plane=16, beam_spacing_deg=3.0, beam_width_deg=3.0,
            plane_elevation_deg=list(planes), range0_m=0.1, dr_m=0.1, samples=256,
        )
    )  # fmt: skip
