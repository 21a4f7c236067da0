"""`python -m benchmarks.false_alarm`: the false-alarm rate that comes true, over the one that is set.

Pure speckle, 60 x 2000, recorded as sonars do; each figure with the standard error of its mean over the images.
"""

import argparse
from typing import Any

import numpy as np

from ods.base.arrays import AnyArray, Floats
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings

BEAMS, SAMPLES = 60, 2000
Stages = tuple[dict[str, Any], ...]
KINDS: dict[str, dict[str, Any]] = {
    "u1 linear": {"dtype": "u1"},
    "u2 linear": {"dtype": "u2"},
    "u1 log8": {"dtype": "u1", "scale": "log8", "scale_factor": 40.0},
    "u2 db": {"dtype": "u2", "scale": "db", "scale_factor": 0.01},
}
FILTERS: dict[str, Stages] = {
    "none": (),
    "FIR": ({"use": "filter.fir"},),
    "FIR 3x9": ({"use": "filter.fir", "beams": 3},),
    "box": ({"use": "filter.box"},),
    "Gaussian": ({"use": "filter.gaussian"},),
    "IIR": ({"use": "filter.iir"},),
    "median": ({"use": "filter.median"},),
    "median 3x9": ({"use": "filter.median", "beams": 3},),
    "Wiener": ({"use": "filter.wiener"},),
}
CFAR = ("ca", "goca", "soca", "os")
RATES = (1e-3, 1e-4, 1e-5)
ONE_LEVEL = {"use": "detect.one_level", "levels": "false_alarm"}


def chain_of(filters: Stages, detector: dict[str, Any]) -> Chain:
    """Return a chain that marks the cells above the high level, and no others."""
    only = {"min_cells": 1} | detector
    return Chain(PipelineSettings(stage=({"use": "equalize.mean_range"}, *filters, only), min_range_m=0.0))


def recorded(kind: str, amplitude: Floats) -> Ping:
    """Return the ping of amplitudes (beams, samples) of mean square 1, as one kind of sonar records them."""
    counts: AnyArray
    if kind == "u1 linear":
        counts = np.minimum(20.0 * amplitude, 255.0).astype(np.uint8)
    elif kind == "u2 linear":
        counts = np.minimum(900.0 * amplitude, 65535.0).astype(np.uint16)
    elif kind == "u1 log8":
        counts = np.rint(40.0 * np.log10(1.0 + 30.0 * amplitude)).astype(np.uint8)
    else:
        counts = np.rint(2000.0 * np.log10(1.0 + 300.0 * amplitude)).astype(np.uint16)
    return Ping(
        seq=0, ping_number=0, t_ns=0, t_rx_ns=0, utc_ns=0, beams=BEAMS, samples=SAMPLES, data=counts.tobytes(),
        bearing_rad=np.linspace(-0.78, 0.78, BEAMS).tolist(), range0_m=0.0, dr_m=0.05, sound_speed=1500.0,
        **KINDS[kind],
    )  # fmt: skip


def rates(kind: str, chains: list[Chain], images: int) -> Floats:
    """Return the (chains, images) share of cells marked; all chains get the same images."""
    rng = np.random.default_rng(5)
    shares = np.empty((len(chains), images))
    mask = np.zeros((BEAMS, SAMPLES), np.int32)
    for number in range(images):
        ping = recorded(kind, np.sqrt(rng.exponential(size=mask.shape)))
        for k, chain in enumerate(chains):
            mask[:] = 0
            chain.process(ping, mask)
            shares[k, number] = np.count_nonzero(mask) / mask.size
    return shares


def row(title: str, kind: str, filters: Stages, detector: dict[str, Any], images: int) -> str:
    """Return one line of the table."""
    found = rates(kind, [chain_of(filters, detector | {"rate": rate}) for rate in RATES], images)
    means, errors = found.mean(axis=1) / RATES, found.std(axis=1) / RATES / images**0.5
    cells = "".join(f"{mean:10.2f} +- {error:.2f}" for mean, error in zip(means, errors, strict=True))
    return f"{title:24}{kind:12}{cells}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=int, default=300)
    images = parser.parse_args().images
    print(f"rate that comes true over the rate set, {images} images" + "".join(f"{rate:17.0e}" for rate in RATES))
    for kind in KINDS:
        for name in ("none", "FIR", "median"):
            print(row(name, kind, FILTERS[name], ONE_LEVEL, images), flush=True)
    for name, filters in FILTERS.items():
        if name not in ("none", "FIR", "median"):
            print(row(name, "u1 log8", filters, ONE_LEVEL, images), flush=True)
    for method in CFAR:
        detector = {"use": "detect.cfar", "method": method, "low": 50.0}
        print(row(f"FIR, CFAR {method}", "u1 log8", FILTERS["FIR"], detector, images), flush=True)


if __name__ == "__main__":
    main()
