"""What the methods are tried on: five pings, whence they were taken, and what the last one shows."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.heavy_tails import SHAPE, ping_of, texture
from ods.assess.images.held_out import held_out_images
from ods.assess.images.labelled import LabelledImage, Target
from ods.assess.images.sea import SEA_SONAR, labelled_image
from ods.assess.images.tank import tank_images
from ods.assess.sea.run import scene_with_seed
from ods.base.arrays import Floats
from ods.base.shipped import shipped_file
from ods.messages import Ping
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.sonar.model import load_sonar

PINGS = 5
BEDS = ("gentle", "slope", "rocky", "ripples", "gravel", "kelp", "school")
"""Of config/scenes/sea; the others have walls or a surface, which no box describes."""
COUNTS_DB = (3.0, math.inf)
"""Signal to noise ratio of a body that has to be found."""
PLACES = [(10, 400), (24, 900), (38, 1300), (50, 1700)]
"""First beam and sample of the bodies, of"""
BODY = (2, 24)
"""beams x samples."""


class Look(NamedTuple):
    """One ping, and place (3,) NED and attitude (4,) of the sonar's head then."""

    ping: Ping
    place: Floats
    attitude: Floats


@dataclass(frozen=True, eq=False)
class Case:
    """Some looks, of which the last one is judged."""

    looks: list[Look]
    targets: list[Target]


def still(ping: Ping) -> Look:
    """Return the look of a vehicle at rest."""
    return Look(ping, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))


def clutter_cases(
    count: int, seed: int, shape: float = 0.0, patches: bool = False, body_db: float | None = None
) -> list[Case]:
    """Return images of speckle, K-distributed if there is a shape, with bodies so many dB over the mean.

    The texture is that of the place and stays over the pings; the speckle is new in each.
    """
    cases = []
    for k in range(count):
        intensity = texture(shape, patches, np.random.default_rng([seed, k])) if shape > 0.0 else np.ones(SHAPE)
        if body_db is not None:
            for beam, sample in PLACES:
                intensity[beam : beam + BODY[0], sample : sample + BODY[1]] += 10.0 ** (body_db / 10.0)
        looks = [still(ping_of(intensity, np.random.default_rng([seed, k, ping]))) for ping in range(PINGS)]
        cases.append(Case(looks, _bodies(looks[0].ping) if body_db is not None else []))
    return cases


def _bodies(ping: Ping) -> list[Target]:
    """Return the boxes of the bodies, one larger on each side."""
    bearing, spacing = np.array(ping.bearing_rad), ping.bearing_rad[1] - ping.bearing_rad[0]
    return [
        Target(
            tuple(ping.range0_m + ping.dr_m * (sample + np.array((-1, 2)) * BODY[1])),
            (float(bearing[beam] - BODY[0] * spacing), float(bearing[beam + BODY[0] - 1] + BODY[0] * spacing)),
        )
        for beam, sample in PLACES
    ]


def bed_cases(count: int, seed: int) -> list[Case]:
    """Return so many images of each of the sea-beds, evenly over the scene's time. Raises ConfigError."""
    return [case for bed in BEDS for case in _of_bed(shipped_file(f"scenes/sea/{bed}.toml"), count, seed)]


def _of_bed(file: Path, count: int, seed: int) -> Iterator[Case]:
    sonar = load_sonar(shipped_file(SEA_SONAR))
    scene = scene_with_seed(file, seed)
    images = ImageSimulator(sonar, scene)
    for k in range(count):
        last = round((k + 0.5) * scene.file.duration_s / count / sonar.ping_period_s)
        last = max(last, PINGS - 1)
        looks, targets = [], []
        for number in range(last - PINGS + 1, last + 1):
            t_s = number * sonar.ping_period_s
            if number < last:
                ping = images.ping(t_s, number, 0, 0)
            else:
                labelled = labelled_image(images, t_s, number, COUNTS_DB)
                ping, targets = labelled.ping, labelled.targets
            looks.append(Look(ping, *scene.head_at(t_s)))
        yield Case(looks, targets)


def tank_cases(count: int, seed: int) -> list[Case]:
    """Return single look-alikes of tank images."""
    return _single(tank_images(count, seed))


def held_out_cases(count: int, seed: int) -> list[Case]:
    """Return single look-alikes by the other model."""
    return _single(held_out_images(count, seed))


def _single(images: list[LabelledImage]) -> list[Case]:
    return [Case([still(image.ping)], image.targets) for image in images]
