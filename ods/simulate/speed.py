"""Time of an image: `ods simulate --table`, table 1 of [SSIE] redrawn, and the figures behind `--chart`."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.ndimage import uniform_filter

from ods.base.arrays import Floats
from ods.sim_sonar.by_name import find_scene
from ods.sim_sonar.echo.rays.detail import LEVEL_ERRORS
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.mean_area import Surroundings, mean_area
from ods.sim_sonar.pose import Transmission
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.receiver.signal_chain import Receiver
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sonar.grid import grid_of
from ods.sim_sonar.sonar.model import SonarModel

TABLE_SCENES = ("figure11_imperfect", "rough_figure11")
TABLE_1 = {"objects": 85, "sea-bed": 103, "imperfections": 7, "noise": 29, "total": 224}
"""CPU seconds of the paper, MATLAB on an HP 9000/735."""
NOISE_KEYS = ("gain", "noise_counts", "looks", "range_correlation", "beam_correlation", "coherence_s")
"""Levels that are no imperfection."""
SMOOTHING = (3, 9)
"""Beams and samples over which images are averaged before they are compared."""


class Effort(NamedTuple):
    """How well times are measured."""

    turns: int
    """At least."""
    shortest_s: float
    """CPU time of each figure, at least."""


THOROUGH, QUICK = Effort(41, 0.1), Effort(5, 0.0)


@dataclass(frozen=True)
class CurvePoint:
    """One model level on one scene."""

    max_error: float
    ms: float
    """CPU time of a whole image."""
    error: float
    """Rms of the smoothed mean image's difference to the reference, over that image's rms."""


@dataclass(frozen=True)
class Curve:
    """All model levels on one scene but the reference, coarsest first, and what the scene's own budget picks."""

    scene: str
    points: list[CurvePoint]
    picked: CurvePoint


def parts_of(sonar: SonarModel, scene: Scene, effort: Effort = THOROUGH) -> dict[str, float]:
    """Return the CPU time, ms, of the parts of an image, under the names of table 1."""
    file, grid = scene.file, grid_of(sonar)
    sent = Transmission(scene.head_at(0.0))
    plain = ImageLevels(**{name: getattr(file.image, name) for name in NOISE_KEYS})
    imperfect, perfect = Receiver(sonar, file.image, file.seed), Receiver(sonar, plain, file.seed)
    whole = Surroundings(scene.bodies_at(0.0), scene.sea_bed, file.shadows)

    def area_of(surroundings: Surroundings) -> Floats:
        return mean_area(grid, surroundings, sent.pose, file.image.max_error)

    area = area_of(whole)
    clean = cpu_ms(effort, lambda: perfect.receive(area, sent))
    dirty = cpu_ms(effort, lambda: imperfect.receive(area, sent))
    images = ImageSimulator(sonar, scene)
    times = iter(np.arange(1e6) * sonar.ping_period_s)
    return {
        "objects": cpu_ms(effort, lambda: area_of(whole._replace(sea_bed=None))),
        "sea-bed": cpu_ms(effort, lambda: area_of(whole._replace(objects=whole.objects[:0]))),
        "imperfections": max(0.0, dirty - clean),
        "noise": clean,
        "total": cpu_ms(effort, lambda: images.render(float(next(times)) % file.duration_s, 0)),
    }


def print_table(sonar: SonarModel) -> None:
    """Print table 1 with the times of this machine beside the paper's. Raises ConfigError for a missing scene."""
    measured = {name: parts_of(sonar, find_scene(name)) for name in TABLE_SCENES}
    shown = Table(title=f"CPU time of one image, {sonar.beams} x {sonar.samples}")
    shown.add_column("part")
    shown.add_column("[SSIE] table 1, s", justify="right")
    for name in measured:
        shown.add_column(f"{name}, ms", justify="right")
    for part, seconds in TABLE_1.items():
        shown.add_row(part, str(seconds), *(f"{times[part]:.2f}" for times in measured.values()))
    Console().print(shown)


def curve_of(sonar: SonarModel, name: str, effort: Effort = THOROUGH) -> Curve:
    """Measure all model levels on the scene of that name. Raises ConfigError."""
    scene = find_scene(name)
    file, grid = scene.file, grid_of(sonar)
    sent, receiver = Transmission(scene.head_at(0.0)), Receiver(sonar, file.image, file.seed)
    surroundings = Surroundings(scene.bodies_at(0.0), scene.sea_bed, file.shadows)

    def area_of(max_error: float) -> Floats:
        return mean_area(grid, surroundings, sent.pose, max_error)

    *forced, finest = LEVEL_ERRORS
    reference = area_of(finest)
    chosen = sorted({*forced, file.image.max_error}, reverse=True)
    noise, *areas = interleaved_ms(
        [lambda: receiver.receive(reference, sent)] + [partial(area_of, level) for level in chosen], effort
    )
    points = [
        CurvePoint(level, noise + ms, relative_error(area_of(level), reference))
        for level, ms in zip(chosen, areas, strict=True)
    ]
    return Curve(name, points, points[chosen.index(file.image.max_error)])


def relative_error(area: Floats, reference: Floats) -> float:
    """Return rms(area - reference) / rms(reference), both smoothed, (beams, samples); 0 where both are empty."""
    size = float(np.linalg.norm(_smooth(reference)))
    return float(np.linalg.norm(_smooth(area - reference))) / size if size > 0.0 else float(np.any(area != 0.0))


def cpu_ms(effort: Effort, job: Callable[[], object]) -> float:
    """Return the median CPU time of a job, ms."""
    return interleaved_ms([job], effort)[0]


def interleaved_ms(jobs: Sequence[Callable[[], object]], effort: Effort = THOROUGH) -> list[float]:
    """Return the median CPU time of each job, ms; they take turns, so that a busy machine hits all alike."""
    for job in jobs:
        job()
    spent: list[list[float]] = []
    while len(spent) < effort.turns or sum(map(sum, spent)) < effort.shortest_s * len(jobs):
        spent.append([_cpu_s(job) for job in jobs])
    return [1e3 * float(value) for value in np.median(spent, axis=0)]


def _cpu_s(job: Callable[[], object]) -> float:
    """Time a job whose data are in the cache, whatever ran before."""
    job()
    began = time.thread_time()
    job()
    return time.thread_time() - began


def _smooth(image: Floats) -> Floats:
    return np.asarray(uniform_filter(image, SMOOTHING, mode="nearest"))
