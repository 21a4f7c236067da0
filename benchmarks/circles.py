"""`python -m benchmarks.circles`: errors of the circles of bodies of known shape, and whether the sigmas match them.

Echoes are made here, by quadrature over the body, and by nothing of the simulator. A cell hears the sum of intensities
over the body's lit points, weighted with a Gaussian beam of -3 dB width 1.5 deg, plus a background of 1, under
exponential speckle. The circle of a front is the sphere's, of a disc the disc's, of a plate the one around it; the near
edge is the body's nearest point, that of a plate its front.
"""

import argparse
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32
from ods.messages import Detection, Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings

BEAMS, SAMPLES, DR_M = 60, 2000, 0.05
SPACING = np.radians(1.5)
SIGMA = SPACING / np.sqrt(8.0 * np.log(2.0))
BEARINGS = (np.arange(BEAMS) - 0.5 * (BEAMS - 1)) * SPACING
BODIES = (("front", 1.5), ("front", 3.0), ("disc", 1.5), ("disc", 3.0), ("plate", 1.5), ("plate", 3.0), ("point", 0.0))
RANGES_M = (20.0, 50.0, 90.0)
SNR_DB = (6.0, 10.0, 15.0, 25.0)
GATE_SIGMAS = 4.0
"""`tracker.gate_sigmas`."""
GATE_M = 6.0
"""A detection farther than this from the body's front is not of the body."""


class Points(NamedTuple):
    """Lit points of a body whose centre is at the origin, (n,)."""

    ahead: Floats
    """Away from the sonar, m."""
    across: Floats
    up: Floats
    weight: Floats


def front(radius: float, cd: float = 0.3, cs: float = 0.3, roughness: float = np.radians(15.0)) -> Points:
    """Return the lit half of a sphere: gamma(alpha) of [SSIE] eqs. 3 and 4 times the surface as seen."""
    cosine, around = np.meshgrid((np.arange(400) + 0.5) / 400, 2.0 * np.pi * (np.arange(96) + 0.5) / 96, indexing="ij")
    alpha, sine = np.arccos(cosine), np.sqrt(1.0 - cosine**2)
    facets = np.minimum(1.0, 2.0 * cosine**2) * np.exp(-(alpha**2) / (2.0 * roughness**2)) / cosine
    weight = (cd * cosine + cs * facets) * cosine
    points = (-radius * cosine, radius * sine * np.cos(around), radius * sine * np.sin(around), weight)
    return Points(*(values.ravel() for values in points))


def disc(radius: float) -> Points:
    """Return a disc in the sonar's plane that shines all over."""
    ahead, across = np.meshgrid(*[radius * (np.arange(200) + 0.5 - 100) / 100] * 2)
    inside = np.hypot(ahead, across) < radius
    return Points(ahead[inside], across[inside], np.zeros(inside.sum()), np.ones(inside.sum()))


def plate(half_width: float) -> Points:
    """Return a line across the line of sight."""
    across = half_width * (np.arange(400) + 0.5 - 200) / 200
    return Points(np.zeros(400), across, np.zeros(400), np.ones(400))


def body(kind: str, size: float) -> Points:
    """Return the points of one of BODIES."""
    return {"front": front, "disc": disc, "plate": plate, "point": lambda _: plate(1e-3)}[kind](size)


def mean_intensity(points: Points, range_m: float, bearing: float) -> Floats:
    """Return what the body adds to each cell, at most 1, (BEAMS, SAMPLES)."""
    away = range_m + points.ahead
    horizontal = np.hypot(away, points.across)
    column = np.rint(np.hypot(horizontal, points.up) / DR_M).astype(np.int64)
    offset = BEARINGS[:, None] - (bearing + np.arctan2(points.across, away))
    gain = np.exp(-(offset**2) / (2.0 * SIGMA**2)) * points.weight
    image = np.array([np.bincount(column, weights, SAMPLES) for weights in gain])
    return np.asarray(image / image.max())


def ping_of(amplitude: Floats32) -> Ping:
    """Return the ping of float32 amplitudes (BEAMS, SAMPLES)."""
    return Ping(
        seq=0, ping_number=0, t_ns=0, t_rx_ns=0, utc_ns=0, beams=BEAMS, samples=SAMPLES, dtype="f4",
        data=amplitude.astype(np.float32).tobytes(), bearing_rad=BEARINGS.tolist(), range0_m=0.0, dr_m=DR_M,
        sound_speed=1500.0,
    )  # fmt: skip


class Look(NamedTuple):
    """One look at a body, and what the chain found of it."""

    range_m: float
    bearing: float
    radius_m: float
    near_m: float
    found: Detection | None


def looks(chain: Chain, kind: str, size: float, range_m: float, snr_db: float, count: int) -> Iterator[Look]:
    """Look at a body at bearings anywhere between two beams, each time in other speckle."""
    rng = np.random.default_rng([int(range_m), int(snr_db), int(10 * size), len(kind)])
    points = body(kind, size)
    near_m = range_m + float(points.ahead.min())
    for bearing in rng.uniform(-0.35, 0.35, count):
        mean = 1.0 + 10.0 ** (0.1 * snr_db) * mean_intensity(points, range_m, bearing)
        amplitude = 30.0 * np.sqrt(mean * rng.exponential(size=mean.shape))
        near = [
            d
            for d in chain.process(ping_of(amplitude)).detections
            if np.hypot(d.range_m - range_m, (d.bearing_rad - bearing) * range_m) < GATE_M
        ]
        yield Look(range_m, bearing, size, near_m, max(near, key=lambda d: d.snr_db, default=None))


class Errors(NamedTuple):
    """Of near edge, centre, radius and bearing of the looks in which something was found: (found, 4)."""

    wrong: Floats
    """m, m, m, rad."""
    claimed: Floats
    """Standard deviations."""


def errors_of(seen: list[Look]) -> Errors:
    """Return what is wrong with what was found, and what it claims to be."""
    wrong = [
        (d.near_m - near_m, d.range_m - range_m, d.radius_m - radius, d.bearing_rad - bearing)
        for range_m, bearing, radius, near_m, d in seen
        if d is not None
    ]
    found = [look.found for look in seen if look.found is not None]
    claimed = [(d.sigma_near_m, d.sigma_range_m, d.sigma_radius_m, d.sigma_bearing_rad) for d in found]
    return Errors(np.array(wrong).reshape(-1, 4), np.array(claimed).reshape(-1, 4))


def figures(errors: Errors) -> str:
    """Return the columns of the table; the last ones leave out errors beyond the tracker's gate."""
    if not len(errors.wrong):
        return " nothing found"
    square = (errors.wrong / errors.claimed) ** 2
    inside = np.ma.masked_array(square, square > GATE_SIGMAS**2).mean(0).filled(np.nan)
    columns = (errors.wrong.mean(0)[:3], np.sqrt((errors.claimed**2).mean(0))[:3], square.mean(0), inside)
    formats = ("{:+7.2f}", "{:7.2f}", "{:7.2f}", "{:7.2f}")
    return " |".join("".join(f.format(v) for v in values) for f, values in zip(formats, columns, strict=True))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--looks", type=int, default=40)
    args = parser.parse_args()
    chain = Chain(PipelineSettings())
    print("                               | near edge, centre, radius | near edge, centre, radius, bearing:")
    print(
        "body     radius range SNR found|       bias, m       | claimed sigma, m    |     error^2/sigma^2        |",
        end="",
    )
    print(" within 4 sigma")
    every: dict[str, list[Errors]] = {}
    for kind, size in BODIES:
        for range_m in RANGES_M:
            for snr_db in SNR_DB:
                seen = list(looks(chain, kind, size, range_m, snr_db, args.looks))
                errors = errors_of(seen)
                every.setdefault(kind, []).append(errors)
                share = len(errors.wrong) / len(seen)
                print(f"{kind:8}{size:6.1f}{range_m:7.0f}{snr_db:4.0f}{share:6.2f}|{figures(errors)}", flush=True)
    for kind, many in every.items():
        whole = Errors(*(np.concatenate(parts) for parts in zip(*many, strict=True)))
        print(f"{kind:8}{'all':>6}{'':17}|{figures(whole)}")


if __name__ == "__main__":
    main()
