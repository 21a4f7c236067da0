"""`python -m benchmarks.detection.false_alarm`: the false-alarm rate that comes true, over the one that is set.

Clutter without echoes, or with some, 60 x 2000, recorded as sonars do; each figure with the standard error of its mean
over the images. A star marks rows with a figure off by more than a factor of 1.5.
"""

import argparse
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from benchmarks.detection.clutter import Clutter, correlated, k_distributed, looks, moving_mean, trend, with_objects
from ods.base.arrays import AnyArray, Floats
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import AttentionSettings, PipelineSettings

BEAMS, SAMPLES, DR_M = 60, 2000, 0.05
Stages = tuple[dict[str, Any], ...]
KINDS: dict[str, dict[str, Any]] = {
    "u1 linear": {"dtype": "u1"},
    "u2 linear": {"dtype": "u2"},
    "u1 log8": {"dtype": "u1", "scale": "log8", "scale_factor": 40.0},
    "u2 db": {"dtype": "u2", "scale": "db", "scale_factor": 0.01},
}
DEFAULT = PipelineSettings().at_spacing(DR_M)
EQUALIZED: Stages = ({"use": "equalize.mean_range"},)
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
CHAINS: dict[str, tuple[Stages, dict[str, Any]]] = {
    **{name: (EQUALIZED + stages, ONE_LEVEL) for name, stages in FILTERS.items()},
    "as recorded": ((), ONE_LEVEL),
    "default": (DEFAULT.stage[:-1], ONE_LEVEL),
    **{
        f"CFAR {method}": (EQUALIZED + FILTERS["FIR"], {"use": "detect.cfar", "method": method, "low": 50.0})
        for method in CFAR
    },
}
"""Stages before the detector, and the detector; CFAR behind a FIR filter."""
MAIN_CHAINS = ("none", "FIR", "median", "default", "CFAR ca", "as recorded")
SPECKLE = looks(1)
CLUTTER: dict[str, Clutter] = {
    "1 look": SPECKLE,
    "2 looks": looks(2),
    "4 looks": looks(4),
    **{f"K {shape:g}": k_distributed(shape) for shape in (0.5, 1.0, 2.0, 5.0)},
    **{f"K {shape:g}, patches": k_distributed(shape, (1.0, 8.0)) for shape in (0.5, 1.0, 2.0, 5.0)},
    "field over 2 samples": moving_mean(2),
    "field correlated, 2": correlated(2.0),
    "1 look, 12 dB louder far": trend(4.0, SPECKLE),
    "4 looks, 12 dB louder far": trend(4.0, looks(4)),
}


def chain_of(stages: Stages, detector: dict[str, Any], rate: float) -> Chain:
    """Return a chain that marks the cells above the high level, and no others."""
    only = {"min_cells": 1, "rate": rate} | detector
    attention = DEFAULT.attention if stages == DEFAULT.stage[:-1] else AttentionSettings()
    return Chain(PipelineSettings(stage=(*stages, only), attention=attention, min_range_m=0.0))


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
        bearing_rad=np.linspace(-0.78, 0.78, BEAMS).tolist(), range0_m=0.0, dr_m=DR_M, sound_speed=1500.0,
        **KINDS[kind],
    )  # fmt: skip


def rates(kind: str, chains: list[Chain], images: int, clutter: Clutter = SPECKLE, objects: int = 0) -> Floats:
    """Return the (chains, images) share of cells marked; all chains get the same images.

    objects: in each image; cells in and near one do not count.
    """
    rng = np.random.default_rng(5)
    shares = np.empty((len(chains), images))
    mask = np.zeros((BEAMS, SAMPLES), np.int32)
    for number in range(images):
        amplitude, near = with_objects(rng, clutter(rng, mask.shape), objects)
        ping = recorded(kind, amplitude)
        for k, chain in enumerate(chains):
            mask[:] = 0
            chain.process(ping, mask)
            shares[k, number] = np.count_nonzero(mask[~near]) / np.count_nonzero(~near)
    return shares


def rows(kind: str, clutter: str, names: Iterable[str], images: int, objects: int) -> Iterator[str]:
    """Yield lines of the table: one sort of clutter behind several chains, which get the same images."""
    chains = [chain_of(*CHAINS[name], rate) for name in names for rate in RATES]
    found = rates(kind, chains, images, CLUTTER[clutter], objects).reshape(-1, len(RATES), images)
    for name, shares in zip(names, found, strict=True):
        means = shares.mean(axis=1) / RATES
        errors = shares.std(axis=1) / RATES / images**0.5
        cells = "".join(f"{mean:10.2f} +- {error:.2f}" for mean, error in zip(means, errors, strict=True))
        outside = " " if max(*means, *(1.0 / np.maximum(means, 1e-9))) <= 1.5 else "*"
        yield f"{clutter:26}{name:12}{kind:12}{cells} {outside}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=int, default=100)
    parser.add_argument("--kinds", nargs="+", default=["u1 linear", "u2 linear", "u1 log8"], choices=KINDS)
    parser.add_argument("--chains", nargs="+", default=MAIN_CHAINS, choices=CHAINS)
    parser.add_argument("--clutter", nargs="+", default=list(CLUTTER), choices=CLUTTER)
    parser.add_argument("--objects", type=int, default=0, help="in each image: ten fill 1 %% of it")
    args = parser.parse_args()
    print(f"rate that comes true over the rate set, {args.images} images" + "".join(f"{rate:17.0e}" for rate in RATES))
    for kind in args.kinds:
        for clutter in args.clutter:
            for line in rows(kind, clutter, args.chains, args.images, args.objects):
                print(line, flush=True)


if __name__ == "__main__":
    main()
