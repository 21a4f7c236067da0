"""`python -m benchmarks.no_data`: false echoes in images of pure speckle of which parts hold no data.

Rayleigh speckle, 60 x 2000, 8-bit linear; the samples without data are 0, and nothing tells which they are ("found") or
the ping does ("reported"). Beside them quiet images, in which most samples are 0 because nothing reaches one count.
"""

import argparse
from collections.abc import Callable
from functools import partial
from typing import Any

import msgspec
import numpy as np

from ods.base.arrays import Bytes, Mask
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.sonar_link.ping_builder import runs_where

BEAMS, SAMPLES = 60, 2000
MEAN_COUNTS = 30.0
SHARES = (0.25, 0.4, 0.5, 0.6)
QUIET_RMS = (0.2, 0.3, 0.5, 0.7, 1.0, 1.5)
CHAINS: dict[str, tuple[dict[str, Any], ...]] = {
    "default": (),
    "Wiener": ({"use": "equalize.mean_range"}, {"use": "filter.wiener"}, {"use": "filter.box"},
               {"use": "detect.two_level", "high": 5.5}),
    "median, CFAR": ({"use": "equalize.mean_range"}, {"use": "filter.median", "beams": 3},
                     {"use": "detect.cfar", "rate": 1e-6}),
    "median_range, IIR": ({"use": "equalize.median_range"}, {"use": "equalize.beam_gain"}, {"use": "filter.iir"},
                          {"use": "detect.two_level", "high": 5.5}),
    "no filter": ({"use": "equalize.mean_range"}, {"use": "detect.two_level", "high": 5.5}),
}  # fmt: skip


def scattered(share: float, rng: np.random.Generator) -> Mask:
    """Return the samples of a (beams, samples) image that are lost, each by itself."""
    return np.asarray(rng.random((BEAMS, SAMPLES)) < share)


def cut_short(share: float, rng: np.random.Generator) -> Mask:
    """Every beam ends at a range of its own."""
    ends = (
        SAMPLES * (1.0 - 2.0 * share * rng.random(BEAMS))
        if share <= 0.5
        else SAMPLES * ((1.0 - share) * 2.0 * rng.random(BEAMS))
    )
    return np.asarray(np.arange(SAMPLES) >= ends[:, None])


def far_end(share: float, _rng: np.random.Generator) -> Mask:
    """All beams end at one range."""
    return np.broadcast_to(np.arange(SAMPLES) >= (1.0 - share) * SAMPLES, (BEAMS, SAMPLES)).copy()


def dead_beams(share: float, rng: np.random.Generator) -> Mask:
    """Some beams are silent."""
    return np.broadcast_to(rng.permutation(BEAMS)[:, None] < share * BEAMS, (BEAMS, SAMPLES)).copy()


PATTERNS: dict[str, Callable[[float, np.random.Generator], Mask]] = {
    "scattered": scattered, "cut short": cut_short, "far end": far_end, "dead beams": dead_beams,
}  # fmt: skip


def ping_of(counts: Bytes, number: int) -> Ping:
    """Return the ping of uint8 counts (beams, samples)."""
    return Ping(
        seq=number, ping_number=number, t_ns=number * 150_000_000, t_rx_ns=0, utc_ns=0, beams=BEAMS, samples=SAMPLES,
        dtype="u1", data=counts.tobytes(), bearing_rad=np.linspace(-0.78, 0.78, BEAMS).tolist(), range0_m=0.0,
        dr_m=0.05, sound_speed=1500.0,
    )  # fmt: skip


def false_echoes(chain: Chain, lose: Callable[[np.random.Generator], Mask], images: int, *, reported: bool) -> float:
    """Return the detections an image of speckle of which some samples are lost."""
    rng, found = np.random.default_rng(7), 0
    for number in range(images):
        amplitude = MEAN_COUNTS / 0.886 * np.sqrt(rng.exponential(size=(BEAMS, SAMPLES)))
        lost = lose(rng)
        ping = ping_of(np.where(lost, 0, np.minimum(amplitude, 255.0)).astype(np.uint8), number)
        if reported:
            ping = msgspec.structs.replace(ping, no_data=runs_where(lost))
        found += len(chain.process(ping).detections)
    return found / images


def of_quiet(chain: Chain, rms: float, images: int) -> float:
    """Return the detections an image of speckle of so many counts rms."""
    rng, found = np.random.default_rng(8), 0
    for number in range(images):
        amplitude = rms * np.sqrt(rng.exponential(size=(BEAMS, SAMPLES)))
        found += len(chain.process(ping_of(amplitude.astype(np.uint8), number)).detections)
    return found / images


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=int, default=100)
    parser.add_argument("--reported", action="store_true")
    parser.add_argument("--chain", default="default", choices=CHAINS)
    args = parser.parse_args()
    chain = Chain(PipelineSettings(stage=CHAINS[args.chain], min_range_m=0.0))
    whole = false_echoes(chain, partial(scattered, 0.0), args.images, reported=args.reported)
    print(f"{args.chain}: false echoes an image, {args.images} images; whole {whole:.3f}")
    for name, pattern in PATTERNS.items():
        cells = [false_echoes(chain, partial(pattern, share), args.images, reported=args.reported) for share in SHARES]
        columns = "".join(f"  {share:.0%} {cell:8.3f}" for share, cell in zip(SHARES, cells, strict=True))
        print(f"{name:12}{columns}", flush=True)
    print("quiet       " + "".join(f"  {rms} {of_quiet(chain, rms, args.images):.3f}" for rms in QUIET_RMS))


if __name__ == "__main__":
    main()
