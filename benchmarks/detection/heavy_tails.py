"""Levels that follow the background's crests: false echoes on K-distributed images, and what they cost on speckle.

Images are 60 x 2000 samples of 16 bits through the default chain. Clutter: speckle times a texture of Gamma distributed
intensity, of independent cells or of patches of 16 samples x 1.4 beams; then bodies of 24 samples x 2 beams on speckle.
"""

import argparse
from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.stats import gamma, norm

from ods.base.arrays import Floats
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import DEFAULT_STAGES, PipelineSettings

SHAPE = 60, 2000
FOLLOW = (0.0, 0.6, 1.0)
HIGH = (5.5, 4.55)
"""The default, and what has about one false echo in an image of speckle."""
PATCH = (0.7, 8.0)
BODY_DB = (3.0, 4.0, 5.0, 6.0, 8.0)
PLACES = [(10, 400), (24, 900), (38, 1300), (50, 1700)]


def chain_of(follow: float, high: float) -> Chain:
    """Return the default chain with other levels."""
    *filters, detector = DEFAULT_STAGES
    return Chain(PipelineSettings(stage=(*filters, {**detector, "follow": follow, "high": high})))


def ping_of(intensity: Floats, rng: np.random.Generator) -> Ping:
    """Return a ping of speckle of that mean intensity, (beams, samples)."""
    counts = 300.0 * np.sqrt(intensity * rng.standard_exponential(SHAPE))
    return Ping(
        seq=0, ping_number=0, t_ns=0, t_rx_ns=0, utc_ns=0, beams=SHAPE[0], samples=SHAPE[1], dtype="u2", scale="linear",
        scale_factor=1.0, range0_m=0.05, dr_m=0.05, bearing_rad=np.radians(1.5 * np.arange(-29.5, 30.0)).tolist(),
        elevation_rad=[0.0] * SHAPE[0], sound_speed=1500.0, data=counts.astype("<u2").tobytes(),
    )  # fmt: skip


def texture(shape: float, patches: bool, rng: np.random.Generator) -> Floats:
    """Return a texture of mean 1, Gamma distributed with that shape."""
    normal = rng.standard_normal(SHAPE)
    if patches:
        normal = gaussian_filter(normal, PATCH)
        normal /= normal.std()
    return np.asarray(gamma.ppf(norm.cdf(normal), shape) / shape)


def false_echoes(make: Callable[[np.random.Generator], Floats], images: int) -> list[float]:
    """Return false echoes an image, for each level each way to follow."""
    pings = [ping_of(make(np.random.default_rng(k)), np.random.default_rng([k, 1])) for k in range(images)]
    chains = [chain_of(follow, high) for high in HIGH for follow in FOLLOW]
    return [float(np.mean([len(chain.process(ping).detections) for ping in pings])) for chain in chains]


def found_share(body_db: float, images: int) -> list[float]:
    """Return the share of bodies found on speckle, so many dB over it, each way to follow."""
    intensity = np.ones(SHAPE)
    for beam, sample in PLACES:
        intensity[beam : beam + 2, sample : sample + 24] += 10.0 ** (body_db / 10.0)
    shares = []
    for chain in (chain_of(follow, HIGH[0]) for follow in FOLLOW):
        found = 0
        for k in range(images):
            mask = np.zeros(SHAPE, np.int32)
            chain.process(ping_of(intensity, np.random.default_rng([k, 2])), mask)
            found += sum(bool(mask[b : b + 2, s : s + 24].any()) for b, s in PLACES)
        shares.append(found / images / len(PLACES))
    return shares


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=int, default=40)
    images = parser.parse_args().images
    print(
        "| background | " + " | ".join(f"high {high:g}, follow {follow:g}" for high in HIGH for follow in FOLLOW), "|"
    )
    print("|---" * (1 + len(HIGH) * len(FOLLOW)) + "|")
    print_row("speckle", false_echoes(lambda _: np.ones(SHAPE), images))
    for shape in (5.0, 2.0, 1.0, 0.5):
        for patches in (False, True):
            figures = false_echoes(partial(texture, shape, patches), images)
            print_row(f"K, shape {shape:g}, {'patches' if patches else 'cells'}", figures)
    print("\n| body, dB over speckle | " + " | ".join(f"follow {follow:g}" for follow in FOLLOW), "|")
    print("|---" * (1 + len(FOLLOW)) + "|")
    for body_db in BODY_DB:
        print_row(f"{body_db:g}", found_share(body_db, 2 * images))


def print_row(name: str, figures: list[float]) -> None:
    """Print one line."""
    print(f"| {name} | " + " | ".join(f"{figure:.2f}" for figure in figures), "|", flush=True)


if __name__ == "__main__":
    main()
