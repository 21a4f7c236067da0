"""What an image costs: `ods simulate --table`, table 1 of [SSIE] redrawn, and the figures behind `--chart`."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from scipy.ndimage import uniform_filter

from ods.sim_sonar.bed import Bed
from ods.sim_sonar.detail import levels
from ods.sim_sonar.grid import grid_of
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.imperfection_settings import ImageLevels
from ods.sim_sonar.mean_area import mean_area
from ods.sim_sonar.receiver import Receiver
from ods.sim_sonar.scene import Scene, load_scene
from ods.sim_sonar.sonar import SonarModel

Array = NDArray[np.float64]

SCENES = Path("config/scenes")
TABLE_SCENES = ("figure11_imperfect", "rough_figure11")
TABLE_1 = {"objects": 85, "sea-bed": 103, "imperfections": 7, "noise": 29, "total": 224}
"""CPU seconds of the paper, MATLAB on an HP 9000/735."""
NOISE_KEYS = ("gain", "noise_counts", "looks", "range_correlation", "beam_correlation", "coherence_s")
"""Levels that are no imperfection."""
SMOOTHING = (3, 9)
"""Beams and samples over which images are averaged before they are compared."""
SHORTEST_S, LONGEST_S = 0.02, 0.5
"""How long one figure is measured for."""


@dataclass(frozen=True)
class Point:
    """One model level on one scene."""

    max_error: float
    ms: float
    """CPU time of a whole image."""
    error: float
    """Rms of the smoothed mean image's difference to the reference, over that image's rms."""
    error_db: float
    """Rms of the difference of their levels in dB, noise included."""


@dataclass(frozen=True)
class Curve:
    """All model levels on one scene but the reference, coarsest first, and what the scene's own budget picks."""

    scene: str
    points: list[Point]
    picked: Point


def parts_of(sonar: SonarModel, scene: Scene) -> dict[str, float]:
    """Return the CPU time, ms, of the parts of an image, under the names of table 1."""
    at_start, file, grid = scene.vehicle_at(0.0), scene.file, grid_of(sonar)
    pose = at_start.position_ned, at_start.attitude
    bodies = scene.bodies_at(0.0)
    plain = ImageLevels(**{name: getattr(file.image, name) for name in NOISE_KEYS})
    imperfect, perfect = Receiver(sonar, file.image, file.seed), Receiver(sonar, plain, file.seed)

    def area_of(rows: Array, sea_bed: Bed | None) -> Array:
        return mean_area(grid, rows, sea_bed, *pose, shadows=file.shadows, max_error=file.image.max_error)

    area = area_of(bodies, scene.sea_bed)
    clean = cpu_ms(lambda: perfect.receive(area, *pose, 0.0, 0))
    dirty = cpu_ms(lambda: imperfect.receive(area, *pose, 0.0, 0))
    images = ImageSimulator(sonar, scene)
    times = iter(np.arange(1e6) * sonar.ping_period_s)
    return {
        "objects": cpu_ms(lambda: area_of(bodies, None)),
        "sea-bed": cpu_ms(lambda: area_of(bodies[:0], scene.sea_bed)),
        "imperfections": max(0.0, dirty - clean),
        "noise": clean,
        "total": cpu_ms(lambda: images.render(float(next(times)) % file.duration_s, 0)),
    }


def table(sonar: SonarModel) -> None:
    """Print table 1 with the times of this machine beside the paper's. Raises ConfigError for a missing scene."""
    measured = {name: parts_of(sonar, load_scene(SCENES / f"{name}.toml")) for name in TABLE_SCENES}
    shown = Table(title=f"CPU time of one image, {sonar.beams} x {sonar.samples}")
    shown.add_column("part")
    shown.add_column("[SSIE] table 1, s", justify="right")
    for name in measured:
        shown.add_column(f"{name}, ms", justify="right")
    for part, seconds in TABLE_1.items():
        shown.add_row(part, str(seconds), *(f"{times[part]:.2f}" for times in measured.values()))
    Console().print(shown)


def curve_of(sonar: SonarModel, name: str) -> Curve:
    """Measure all model levels on the scene of that name. Raises ConfigError."""
    scene = load_scene(SCENES / f"{name}.toml")
    start, file, grid = scene.vehicle_at(0.0), scene.file, grid_of(sonar)
    receiver = Receiver(sonar, file.image, file.seed)

    def area_of(max_error: float) -> Array:
        return mean_area(
            grid, scene.bodies_at(0.0), scene.sea_bed, start.position_ned, start.attitude,
            shadows=file.shadows, max_error=max_error,
        )  # fmt: skip

    *forced, finest = levels()
    reference = area_of(finest)
    noise_ms = cpu_ms(lambda: receiver.receive(reference, start.position_ned, start.attitude, 0.0, 0))
    noise_m2 = (file.image.noise_counts / file.image.gain) ** 2

    def point(max_error: float) -> Point:
        area = area_of(max_error)
        ms = noise_ms + cpu_ms(lambda: area_of(max_error))
        return Point(max_error, ms, relative_error(area, reference), error_db(area, reference, noise_m2))

    points = {level: point(level) for level in forced}
    chosen = file.image.max_error
    return Curve(name, list(points.values()), points[chosen] if chosen in points else point(chosen))


def relative_error(area: Array, reference: Array) -> float:
    """Return rms(area - reference) / rms(reference), both smoothed, (beams, samples); 0 where both are empty."""
    size = float(np.linalg.norm(_smooth(reference)))
    return float(np.linalg.norm(_smooth(area - reference))) / size if size > 0.0 else float(np.any(area != 0.0))


def error_db(area: Array, reference: Array, noise: float) -> float:
    """Return the rms difference of the smoothed images' levels, dB, above a floor of `noise`, in their unit."""
    floor = max(noise, 1e-12)
    ratio = (np.maximum(_smooth(area), 0.0) + floor) / (np.maximum(_smooth(reference), 0.0) + floor)
    return float(np.sqrt(np.mean(np.square(10.0 * np.log10(ratio)))))


def cpu_ms(job: Callable[[], object]) -> float:
    """Return the median CPU time of a job, ms, once it is compiled."""
    job()
    spent: list[float] = []
    while (sum(spent) < SHORTEST_S or len(spent) < 30) and sum(spent) < LONGEST_S:
        began = time.thread_time()
        job()
        spent.append(time.thread_time() - began)
    return 1e3 * float(np.median(spent))


def _smooth(image: Array) -> Array:
    return np.asarray(uniform_filter(image, SMOOTHING, mode="nearest"))
