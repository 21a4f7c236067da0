"""`python -m benchmarks.dead_beam`: what is found of bodies behind a beam without data, and how far off it is.

Bodies and looks as in benchmarks/circles.py: fronts and discs of 20 dB, at bearings anywhere between two beams; the
ping tells that the beam through the body's middle holds no data.
"""

import argparse

import msgspec
import numpy as np

from benchmarks.circles import GATE_SIGMAS, SONAR, WIDEST, Case, body, is_of, mean_intensity, ping_of
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings

SNR_DB = 20.0
BODIES = (("front", 1.5, 25.0), ("front", 3.0, 25.0), ("disc", 1.5, 25.0), ("front", 1.5, 50.0))


def row(case: Case, count: int, *, dead: bool) -> str:
    """Return echoes a look, means of squared errors over sigmas across and of the radius, and the radius's error."""
    chain, rng, points = Chain(PipelineSettings()), np.random.default_rng(0), body(case.kind, case.size)
    echoes, square, radius = 0, [], []
    for bearing in rng.uniform(-WIDEST, WIDEST, count):
        mean = 1.0 + 10.0 ** (0.1 * case.snr_db) * mean_intensity(points, case.range_m, bearing)
        amplitude = 30.0 * np.sqrt(mean * rng.exponential(size=mean.shape))
        beam = int(np.abs(SONAR.bearings - bearing).argmin())
        amplitude[beam] *= not dead
        ping = msgspec.structs.replace(ping_of(amplitude), no_data=[(beam, 0, SONAR.samples)] if dead else [])
        found = [d for d in chain.process(ping).detections if is_of(d, case, bearing, points)]
        echoes += len(found)
        for d in sorted(found, key=lambda d: d.snr_db)[-1:]:
            wrong = (d.bearing_rad - bearing) / d.sigma_bearing_rad, (d.radius_m - case.size) / d.sigma_radius_m
            square.append(np.minimum(np.square(wrong), GATE_SIGMAS**2))
            radius.append(d.radius_m - case.size)
    across, size = np.mean(square, 0)
    return f"{echoes / count:8.2f}{across:8.2f}{size:8.2f}{np.mean(radius):+8.2f}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--looks", type=int, default=40, help="images a row")
    args = parser.parse_args()
    print("body   radius range   beam    echoes  across  radius  error, m")
    for kind, size, range_m in BODIES:
        for dead in (False, True):
            case = Case(kind, size, range_m, SNR_DB)
            figures = row(case, args.looks, dead=dead)
            print(f"{kind:6}{size:7.1f}{range_m:6.0f}   {'dead' if dead else 'whole':6}{figures}", flush=True)


if __name__ == "__main__":
    main()
