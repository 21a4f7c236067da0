"""How well the image tells the altitude, and what it costs: `python -m benchmarks.bottom_echo [--images FOLDER]`.

The beds of config/scenes/sea, which are rough, and plain ones with another vertical pattern, slopes and a swinging
pitch. Truth: the depth of the bed under the place where the bottom is told to be.
"""

import argparse
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from ods.assess.sea.assessment import shipped_scenes
from ods.assess.sea.command import SECONDS
from ods.assess.sea.run import head_at, images_of, scene_with_seed
from ods.messages import Ping, frame_of
from ods.pipeline.bottom_echo import BottomEchoFinder
from ods.pipeline.image.no_data import ALL_DATA
from ods.pipeline.plan import sample_scale_of
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.shots import shots_of
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.sonar.patterns import aperture_table
from ods.tracker.output.bottom_seen import bottom_seen

HALF_VERTICAL = np.radians(10.0)
APERTURE = 2.55
"""Wavelengths of an evenly lit aperture whose two-way level is -6 dB at 10 degrees."""
PINGS = 25


class Bed(NamedTuple):
    """Pings over one bed."""

    name: str
    scene: Scene
    pings: list[Ping]


class Score(NamedTuple):
    """Of the pings over one bed."""

    altitude: float
    seen: float
    """Share of the pings."""
    bias: float
    """Of what is told of the height where the bottom is seen, m,"""
    rms: float
    """its rms error,"""
    sigma: float
    """the rms of the standard deviations told,"""
    nees: float
    """and the mean of error squared over variance."""


def main(argv: Sequence[str] | None = None) -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=Path, metavar="FOLDER", help="as of `ods assess sea`")
    args = parser.parse_args(argv)
    print("| bed | altitude, m | seen | bias, m | rms error, m | sigma told, m | NEES |\n|---|---|---|---|---|---|---|")
    cost = []
    for bed in beds(args.images):
        score, times = scored(bed)
        cost += times
        numbers = (
            f"{score.bias:+.2f} | {score.rms:.2f} | {score.sigma:.2f} | {score.nees:.2f}" if score.seen else "| | |"
        )
        print(f"| {bed.name} | {score.altitude:.1f} | {100 * score.seen:.0f} % | {numbers} |", flush=True)
    print(f"\n{1e3 * float(np.median(cost)):.3f} ms an image of 60 x 2000, median of {len(cost)}")


def beds(images: Path | None) -> Iterator[Bed]:
    """Yield the beds of the family, then plain ones."""
    sonar = find_sonar("seabat6012")
    for file in shipped_scenes():
        scene = scene_with_seed(file, 0)
        pings = [ping for ping, _ in images_of(scene, sonar, SECONDS, images)]
        yield Bed(file.stem, scene, pings[:: max(1, len(pings) // PINGS)])
    aperture = replace(sonar, vertical_two_way=np.stack([aperture_table(APERTURE, 0.0)]))
    for altitude in (2.0, 4.0, 6.0, 8.0, 10.0, 15.0):
        yield plain(f"plain, {altitude:g} m, pitch +-3 deg", sonar, altitude)
    for slope in (5.0, -5.0):
        yield plain(f"plain, {'falls' if slope > 0.0 else 'rises'} by 5 deg", sonar, 5.0, slope)
    for altitude in (3.0, 8.0):
        yield plain(f"plain, {altitude:g} m, evenly lit aperture", aperture, altitude)
    for altitude in (20.0, 30.0, 60.0):
        yield plain(f"plain, {altitude:g} m: too deep to be seen", sonar, altitude)


def plain(name: str, sonar: SonarModel, altitude: float, slope_deg: float = 0.0) -> Bed:
    """Return pings over a plane that falls ahead, or rises, seen by a vehicle that pitches and rolls."""
    swing = {"amplitude_deg": 3.0, "period_s": 3.0}
    told = {
        "seed": 7, "duration_s": 30.0,
        "vehicle": {"position_ned": [0.0, 0.0, 30.0], "velocity_ned": [0.0, 0.3, 0.0],
                    "pitch": swing, "roll": {"amplitude_deg": 2.0, "period_s": 4.1}},
        "sea_bed": {"depth_m": 30.0 + altitude, "slope_deg": abs(slope_deg),
                    "slope_heading_deg": 0.0 if slope_deg > 0.0 else 180.0},
    }  # fmt: skip
    scene = Scene(msgspec.convert(told, SceneFile))
    return Bed(name, scene, [ping for ping, _ in islice(shots_of(ImageSimulator(sonar, scene)), PINGS)])


def scored(bed: Bed) -> tuple[Score, list[float]]:
    """Return how well the bottom is told, and the seconds that each image took."""
    altitudes, errors, sigmas, times = [], [], [], []
    for ping in bed.pings:
        head = head_at(bed.scene, ping.t_ns)
        assert bed.scene.sea_bed is not None
        altitudes.append(bed.scene.sea_bed.altitude_of(head.position_ned))
        finder, frame, scale = BottomEchoFinder(ping, 0, float(HALF_VERTICAL)), frame_of(ping), sample_scale_of(ping)
        echo = finder.find(frame, ALL_DATA, scale)
        began = time.perf_counter()
        finder.find(frame, ALL_DATA, scale)
        times.append(time.perf_counter() - began)
        found = None if echo is None else bottom_seen(echo, head, 0.0)
        if found is not None:
            errors.append(-bed.scene.sea_bed.altitude_of(found.place))
            sigmas.append(found.sigma_m)
    return Score(float(np.mean(altitudes)), len(errors) / len(bed.pings), *_spread(errors, sigmas)), times


def _spread(errors: Iterable[float], sigmas: Iterable[float]) -> tuple[float, float, float, float]:
    error, sigma = np.array(list(errors)), np.array(list(sigmas))
    if not len(error):
        return 0.0, 0.0, 0.0, 0.0
    nees = float(np.mean((error / sigma) ** 2))
    return float(error.mean()), float(np.sqrt(np.mean(error**2))), float(np.sqrt(np.mean(sigma**2))), nees


if __name__ == "__main__":
    main()
