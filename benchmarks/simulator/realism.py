"""How real simulated images are: `python -m benchmarks.simulator.realism RECORDING... [--scenes NAME...]`.

Each recording of pings against images that the simulator makes with the same sonar (beams, spacing, samples and ranges
as the recording tells them) over a rough bed, against the tank look-alikes of `ods assess detect`, against scenes of
`ods assess sea` by the SeaBat, and against the other recordings, which shows how far real images lie from each other.
Figures are Kullback-Leibler divergence of the histograms, nats, of real from simulated, and earth mover's distance in
the figure's own unit; per recording it is said what differs most.
"""

import argparse
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter
from scipy.stats import wasserstein_distance

from ods.assess.images.tank import tank_images
from ods.assess.sea.assessment import shipped_scenes
from ods.base.arrays import Floats, Image
from ods.messages import Ping, frame_of
from ods.pipeline.image.missing.threshold import amplitudes_of
from ods.pipeline.image.samples.amplitude import sample_scale
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.scene.settings import SceneFile, Sphere, VehiclePath
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.sea_bed.settings import Roughness, SeaBed
from ods.sim_sonar.sonar.model import SonarModel, make_sonar
from ods.sim_sonar.sonar.settings import SonarFile
from ods.sonar_link.files.opening import open_pings

FRAMES = 6
"""Images of each kind at most."""
WINDOW = 9, 31
"""Beams and samples of the neighbourhood that a sample's level is reported against,"""
BLOCK = 12, 48
"""and of the blocks that have a texture each."""
LOWEST_DB = -40.0
"""What is weaker counts as this weak."""
MOST_SAMPLES = 200_000
"""That make a histogram and a distance."""
SMOOTHING = 0.5
"""Added to each bin's count: an empty one is not infinitely improbable."""
DOWN_M, NEAR_SHARE, BED_SHARE, HEIGHT_SHARE, LENGTH_SHARE = 20.0, 0.012, 0.1, 0.005, 0.05
"""Of the look-alike's scene: depth, and shares of the range: bodies' radius, altitude, the bed's height and length."""
SEA_SONAR, SEA_SCENES = "seabat6012", ("gentle", "rocky", "gravel")


class Measure(NamedTuple):
    """One figure of images whose distribution is compared."""

    unit: str
    bins: Floats
    """Edges of the histogram; what lies outside counts in the outermost."""


MEASURES = {
    "level over the image's median": Measure("dB", np.arange(LOWEST_DB, 61.0, 2.0)),
    "level over its surroundings": Measure("dB", np.arange(LOWEST_DB, 21.0, 2.0)),
    "correlation, next sample": Measure("", np.linspace(-1.0, 1.0, 21)),
    "correlation, fourth sample": Measure("", np.linspace(-1.0, 1.0, 21)),
    "correlation, next beam": Measure("", np.linspace(-1.0, 1.0, 21)),
    "variation within a block": Measure("", np.linspace(0.0, 2.0, 21)),
    "correlation, next ping": Measure("", np.linspace(-1.0, 1.0, 21)),
}
Figures = Mapping[str, Floats]
"""Values of each measure."""


def figures_of(images: Sequence[Image]) -> dict[str, Floats]:
    """Return the values of each measure in consecutive images (beams, samples) of amplitudes, any scale."""
    levels = [level_db(image) for image in images]
    blocks = [blocks_of(level) for level in levels]
    amplitudes = [blocks_of(np.asarray(image, np.float64)) for image in images]
    pings = [correlation(one, other) for one, other in pairwise(blocks)]
    return {
        "level over the image's median": np.concatenate([level.ravel() for level in levels]),
        "level over its surroundings": np.concatenate([surroundings_db(image).ravel() for image in images]),
        "correlation, next sample": np.concatenate([neighbours(each, 0, 1) for each in blocks]),
        "correlation, fourth sample": np.concatenate([neighbours(each, 0, 4) for each in blocks]),
        "correlation, next beam": np.concatenate([neighbours(each, 1, 0) for each in blocks]),
        "variation within a block": np.concatenate([variation(each) for each in amplitudes]),
        "correlation, next ping": np.concatenate(pings) if pings else np.zeros(0),
    }


def level_db(image: Image) -> Floats:
    """Return levels over the median of the image, dB."""
    power = np.asarray(image, np.float64) ** 2
    return _db(power / max(float(np.median(power)), 1e-30))


def surroundings_db(image: Image) -> Floats:
    """Return levels over the mean intensity of each sample's neighbourhood, dB."""
    power = np.asarray(image, np.float64) ** 2
    return _db(power / np.maximum(uniform_filter(power, WINDOW, mode="nearest"), 1e-30))


def _db(ratio: Floats) -> Floats:
    return np.maximum(10.0 * np.log10(np.maximum(ratio, 1e-12)), LOWEST_DB)


def blocks_of(image: Floats) -> Floats:
    """Return whole blocks (n, beams, samples) of an image."""
    beams, samples = (size // step * step for size, step in zip(image.shape, BLOCK, strict=True))
    cut = image[:beams, :samples].reshape(beams // BLOCK[0], BLOCK[0], samples // BLOCK[1], BLOCK[1])
    return cut.swapaxes(1, 2).reshape(-1, *BLOCK)


def neighbours(blocks: Floats, beams: int, samples: int) -> Floats:
    """Return, of each block, the correlation of its samples with those so many beams and samples farther."""
    last_beam, last_sample = BLOCK[0] - beams, BLOCK[1] - samples
    return correlation(blocks[:, :last_beam, :last_sample], blocks[:, beams:, samples:])


def correlation(one: Floats, other: Floats) -> Floats:
    """Return the correlation of blocks (n, ...) pair by pair; flat ones have none."""
    a, b = (each.reshape(len(each), -1) - each.reshape(len(each), -1).mean(axis=1, keepdims=True)
            for each in (one, other))  # fmt: skip
    spread = np.sqrt((a**2).sum(axis=1) * (b**2).sum(axis=1))
    known = spread > 1e-9
    return np.asarray((a * b).sum(axis=1)[known] / spread[known])


def variation(blocks: Floats) -> Floats:
    """Return the standard deviation of each block's amplitude over its mean: 0.52 for speckle of one look."""
    flat = blocks.reshape(len(blocks), -1)
    mean = flat.mean(axis=1)
    known = mean > 0.0
    return np.asarray(flat.std(axis=1)[known] / mean[known])


class Distance(NamedTuple):
    """How far the simulated values of a measure lie from the real ones."""

    divergence: float
    """Kullback-Leibler, nats, of real from simulated."""
    moved: float
    """Earth mover's distance."""


def distance(real: Floats, simulated: Floats, measure: Measure) -> Distance:
    """Return the distances of two samples; NaN where one is empty."""
    if len(real) == 0 or len(simulated) == 0:
        return Distance(np.nan, np.nan)
    p, q = (_shares(values, measure.bins) for values in (real, simulated))
    moved = wasserstein_distance(_some(real), _some(simulated))
    return Distance(float((p * np.log(p / q)).sum()), float(moved))


def _shares(values: Floats, bins: Floats) -> Floats:
    width = bins[1] - bins[0]
    inside = np.clip(values, bins[0] + 0.5 * width, bins[-1] - 0.5 * width)
    count = np.histogram(inside, bins)[0] + SMOOTHING
    return np.asarray(count / count.sum())


def _some(values: Floats) -> Floats:
    return values[:: max(1, len(values) // MOST_SAMPLES)]


# --- images


def amplitudes(ping: Ping) -> Image:
    """Return the amplitudes of a ping, (beams, samples) of its first plane."""
    frame = frame_of(ping)
    image = amplitudes_of(frame, sample_scale(frame.dtype, ping.scale, ping.scale_factor))
    return image[: ping.beams // ping.planes]


def sonar_like(ping: Ping, bearing_deg: NDArray[np.float64]) -> SonarModel:
    """Return a sonar with the beams, samples and ranges of a ping; beams are as wide as they are apart."""
    return make_sonar(
        SonarFile(
            name="as recorded",
            frequency_hz=ping.frequency_hz,
            sound_speed=ping.sound_speed,
            bearing_deg=bearing_deg.tolist(),
            beam_width_deg=float(np.median(np.diff(bearing_deg))),
            range0_m=ping.range0_m,
            dr_m=ping.dr_m,
            samples=ping.samples,
        )
    )


def look_alike(ping: Ping, count: int) -> list[Image]:
    """Return images of a rough bed with two bodies by the ping's sonar, a tenth of a second apart, under way."""
    bearing = np.degrees(np.sort(np.asarray(ping.bearing_rad, np.float64)))
    far_m = ping.range0_m + ping.dr_m * ping.samples
    bodies = [
        Sphere(name=str(k), position_ned=(share * far_m, aside * far_m, DOWN_M + 0.05 * far_m),
               radius_m=NEAR_SHARE * far_m, surface=Surface(cd=0.5, cs=0.25, sigma_deg=15.0))
        for k, (share, aside) in enumerate([(0.5, 0.02), (0.8, -0.05)])
    ]  # fmt: skip
    rough = Roughness(rms_height_m=HEIGHT_SHARE * far_m, correlation_m=LENGTH_SHARE * far_m)
    bed = SeaBed(depth_m=DOWN_M + BED_SHARE * far_m, rough=rough, surface=Surface(cd=0.5, cs=0.2, sigma_deg=20.0))
    # the noise lies far below the bed's echo, which a gain over the square of the range keeps in one span of counts
    vehicle = VehiclePath(position_ned=(0.0, 0.0, DOWN_M), velocity_ned=(0.01 * far_m, 0.0, 0.0))
    gain = 20000.0 / (far_m / 100.0) ** 2
    scene = SceneFile(seed=7, duration_s=60.0, vehicle=vehicle, objects=list(bodies), sea_bed=bed,
                      image=ImageLevels(gain=gain, noise_counts=1.0))  # fmt: skip
    images = ImageSimulator(sonar_like(ping, bearing), Scene(scene))
    return [images.render(0.1 * k, k) for k in range(count)]


def sea(names: Sequence[str], count: int) -> list[Image]:
    """Return images of scenes of the family, consecutive ones of each."""
    sonar, found = find_sonar(SEA_SONAR), list[Image]()
    each = max(2, count // len(names))
    for file in shipped_scenes(names):
        images = ImageSimulator(sonar, load_scene(file))
        found += [amplitudes(images.ping(k * sonar.ping_period_s, k, 0, 0)) for k in range(each)]
    return found


def rows(name: str, real: Figures, others: Mapping[str, Figures]) -> list[str]:
    """Return the lines of one recording against each kind of image, and what differs most."""
    lines, said = [], []
    for against, figures in others.items():
        found = {each: distance(real[each], figures[each], measure) for each, measure in MEASURES.items()}
        cells = [f"{d.divergence:.2f}, {d.moved:.2f}" if np.isfinite(d.moved) else "" for d in found.values()]
        lines.append(f"| {name} | {against} | {' | '.join(cells)} |")
        most = max(found, key=lambda each: np.nan_to_num(found[each].divergence))
        middle = float(np.median(real[most])), float(np.median(figures[most]))
        said.append(f"{name} against {against}: most {most}, medians {middle[0]:.2f} and {middle[1]:.2f}")
    return [*lines, *said]


def main() -> None:
    """Print the table and what differs most."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", type=Path, nargs="+", metavar="RECORDING", help=".aris, Oculus .raw, .npz, .s7k")
    parser.add_argument("--scenes", nargs="+", default=SEA_SCENES, metavar="NAME", help="of `ods assess sea`")
    args = parser.parse_args()
    pings = {path.stem: list(open_pings(path).pings[:FRAMES]) for path in args.recordings}
    real = {name: figures_of([amplitudes(ping) for ping in each]) for name, each in pings.items()}
    tank = figures_of([amplitudes(image.ping) for image in tank_images(FRAMES, 1)])
    tank["correlation, next ping"] = np.zeros(0)  # each is of a scene of its own
    shared = {"tank look-alikes": tank, "sea, SeaBat": figures_of(sea(args.scenes, FRAMES))}
    headings = [f"{each}{', ' if measure.unit else ''}{measure.unit}" for each, measure in MEASURES.items()]
    print(f"| real | against | {' | '.join(headings)} |")
    print(f"|{'---|' * (2 + len(headings))}")
    found = []
    for name, figures in real.items():
        own = figures_of(look_alike(pings[name][0], len(pings[name])))
        others = {other: each for other, each in real.items() if other != name}
        found += rows(name, figures, {"the same sonar, simulated": own, **shared, **others})
    print(*sorted(found, key=lambda line: not line.startswith("|")), sep="\n")


if __name__ == "__main__":
    main()
