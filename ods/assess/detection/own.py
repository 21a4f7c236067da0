"""Settings judged on the user's own images only: labelled frames of recordings, and scenes of the simulator."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.progress import track as progress
from rich.table import Table

from ods.assess.detection.chains import DETECTORS, Detector, Setting, all_settings, setting_of
from ods.assess.detection.measure import Accuracy, accuracy_of, milliseconds, score_of
from ods.assess.detection.metrics import Score, pareto_front
from ods.assess.images.labelled import LabelledImage
from ods.assess.images.labels import read_labels
from ods.assess.images.sea import SNR_DB, labelled_image
from ods.assess.scene_files import scene_files
from ods.base.errors import OdsError
from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.sonar.model import SonarModel
from ods.sonar_link.files.opening import open_pings

CONFIGURED = "configured"
"""Name of the chain of `--config`."""
IMAGES_OF_A_SCENE = 8
"""Spread evenly over its duration."""
FALSE_ALARMS = 1.0
"""An image, at which settings are compared."""


@dataclass(frozen=True)
class OwnRow:
    """Detection performance of a setting on these images."""

    name: str
    ms: float
    swept: Accuracy
    """At FALSE_ALARMS."""
    as_set: Score
    """At its own levels."""


def own_images(
    recordings: Sequence[tuple[Path, Path]], scenes: Sequence[Path], sonar: SonarModel
) -> list[LabelledImage]:
    """Return the labelled frames of recordings, and images of scenes with their truth. Raises OdsError."""
    images: list[LabelledImage] = []
    for recording, labels in recordings:
        images += read_labels(labels, open_pings(recording).pings)
    for file in scene_files(scenes):
        images += scene_images(file, sonar)
    if not any(target.counts for image in images for target in image.targets):
        raise OdsError("--real, --scene: no object is in view of any image, so nothing can be found")
    return images


def scene_images(file: Path, sonar: SonarModel) -> Iterator[LabelledImage]:
    """Yield images of a scene. Raises OdsError."""
    scene = load_scene(file)
    try:
        images = ImageSimulator(sonar, scene)
        for number in range(IMAGES_OF_A_SCENE):
            t_s = number * scene.file.duration_s / IMAGES_OF_A_SCENE
            yield labelled_image(images, t_s, number, (SNR_DB[0], math.inf))
    except ValueError as error:
        raise OdsError(f"{file}: {error}") from error


def configured(settings: PipelineSettings) -> Setting:
    """Return the user's chain with the sweep of its detector's threshold, where that is one of DETECTORS."""
    *filters, last = settings.chain()
    kind = {"method": "ca"} | last
    same = (
        each.sweep
        for each in DETECTORS.values()
        if all(kind.get(name) == value for name, value in each.stage.items() if name in ("use", "method"))
    )
    sweep = next(same, ({},))
    return setting_of(CONFIGURED, tuple(filters), Detector(last, sweep), settings.attention, settings)


def measure_own(
    settings: Sequence[Setting], chosen: Sequence[PipelineSettings], images: Sequence[LabelledImage], rounds: int
) -> list[OwnRow]:
    """Return one row a setting; `chosen`: the step of each one's sweep that stands in the configuration."""
    spent = milliseconds(chosen, images[0].ping, rounds)
    return [
        OwnRow(each.name, ms, accuracy_of(each, images, FALSE_ALARMS), score_of(as_set, images))
        for each, as_set, ms in zip(
            progress(settings, description="assessing", transient=True), chosen, spent, strict=True
        )
    ]


def whole_image_settings() -> list[Setting]:
    """Return the settings without attention, which are the fewer and say what attention then costs to."""
    return [each for each in all_settings() if each.settings[0].attention == PipelineSettings().attention]


def own_table(rows: Sequence[OwnRow], images: Sequence[LabelledImage]) -> Table:
    """Return the table, best first; those on the Pareto front of time and Pd are marked."""
    front = pareto_front([row.ms for row in rows], [row.swept.detection_probability for row in rows])
    targets = sum(target.counts for image in images for target in image.targets)
    table = Table(
        title=f"{targets} objects on {len(images)} images; Pd at {FALSE_ALARMS:g} false alarm an image; * Pareto front"
    )
    for heading in ("setting", "ms", "Pd", "position, m", "radius", "Pd as set", "false alarms as set"):
        table.add_column(heading, justify="left" if heading == "setting" else "right")
    for index in sorted(range(len(rows)), key=lambda i: (-rows[i].swept.detection_probability, rows[i].ms)):
        row = rows[index]
        table.add_row(
            f"{'*' if index in front else ' '} {row.name}",
            f"{row.ms:.3f}",
            f"{row.swept.detection_probability:.3f}",
            _figure(row.swept.position_error_m, ".2f"),
            _figure(row.swept.radius_error, ".0%"),
            f"{row.as_set.detection_probability:.3f}",
            f"{row.as_set.false_per_image:.1f}",
        )
    return table


def _figure(value: float, form: str) -> str:
    """Return a figure that only images with known circles have."""
    return "" if value != value else format(value, form)
