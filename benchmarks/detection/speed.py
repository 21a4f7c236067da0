"""`make benchmark`: milliseconds from recorded samples to detections, ours beside scipy, scikit-image and OpenCV.

All contestants get the same frame and do the same: equalize by range, filter along the beam, two levels, connected
regions, their boxes. They take turns within one run, so that a machine that slows down slows all of them.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
from scipy import ndimage, signal
from skimage import filters as skimage_filters, measure as skimage_measure

from ods.base.arrays import Bytes, Floats32, Image
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.filter.linear import lowpass_weights
from ods.pipeline.settings import AttentionSettings, PipelineSettings

Filter = Callable[[Any], Any]
Task = Callable[[], Any]
ROUNDS = 40
SETTLING, TIMED = 3, 3
"""Runs a turn: the first ones find the caches as the others left them."""
EQUALIZE = {"use": "equalize.mean_range"}
FIR_9 = {"use": "filter.fir", "taps": 9}
DETECT = {"use": "detect.two_level", "min_cells": 4}
CHAINS: dict[str, tuple[dict[str, Any], ...]] = {
    "FIR 9": (FIR_9,),
    "box 9": ({"use": "filter.box"},),
    "median 9": ({"use": "filter.median"},),
    "Wiener 9": ({"use": "filter.wiener"},),
    "FIR 3x9": ({**FIR_9, "beams": 3},),
    "box 3x9": ({"use": "filter.box", "beams": 3},),
    "median 5": ({"use": "filter.median", "window": 5},),
    "median 3x9": ({"use": "filter.median", "beams": 3},),
    "Wiener 3x9": ({"use": "filter.wiener", "beams": 3},),
    "Gaussian 2.5": ({"use": "filter.gaussian"},),
    "Gaussian 2.5 x 0.7": ({"use": "filter.gaussian", "beam_sigma": 0.7},),
    "IIR 3": ({"use": "filter.iir"},),
    "FIR 9, opening 0.45 m": (FIR_9, {"use": "filter.min_object", "size_m": 0.45}),
}
PAPER: dict[str, Any] = {"near_m": 20.0, "every": 4, "margin_m": 2.0}
ATTENTION = {
    "all": AttentionSettings(),
    "2 to 1": AttentionSettings(subsample=2),
    "rings": AttentionSettings(**PAPER),
    "both": AttentionSettings(subsample=2, **PAPER),
}
ATTENTION_CHAINS: dict[str, tuple[dict[str, Any], ...]] = {
    "FIR 9": (EQUALIZE, *CHAINS["FIR 9"], DETECT),
    "default": (),
    "FIR of 0.5 m": (EQUALIZE, {"use": "filter.fir", "object_m": 0.5}, DETECT),
    "Wiener 9": (EQUALIZE, *CHAINS["Wiener 9"], DETECT),
    "median 3x9, CFAR": (EQUALIZE, {"use": "filter.median", "beams": 3}, {"use": "detect.cfar"}),
}
OBJECT_INTENSITY = 3.0
"""Of the weak objects: 5 dB over the speckle."""
TARGETS_MS = {"FIR 9": 0.08, "box 9": 0.08, "median 9": 0.11, "Wiener 9": 0.15, "FIR 3x9": 0.15}
TABLE_2 = (("equalization", 1.27, 0.14), ("filtering", 1.76, 1.06), ("detection", 22.5, 0.27), ("total", 25.53, 1.47))
"""[SSIE] table 2: CPU s an image in MATLAB and in C on a 25 MHz 68040."""


def made_up_ping(
    beams: int,
    samples: int = 2000,
    seed: int = 0,
    objects: Sequence[tuple[int, float]] = ((12, 20.0), (32, 40.0), (47, 75.0)),
    intensity: float = 100.0,
) -> Ping:
    """Return an 8-bit linear ping: speckle of intensity 1, and objects at (beam of 60, range of the near side, m)."""
    rng = np.random.default_rng(seed)
    mean = np.ones((beams, samples))
    for beam, range_m in objects:
        beam, column = beam * beams // 60, round(range_m / 0.05)
        mean[beam : beam + max(3, beams // 20), column : column + 30] = intensity
    amplitude = 10.0 * np.sqrt(mean * rng.exponential(size=mean.shape))
    return Ping(
        seq=0, ping_number=0, t_ns=0, t_rx_ns=0, utc_ns=0, beams=beams, samples=samples, dtype="u1",
        data=np.minimum(amplitude, 255.0).astype(np.uint8).tobytes(), range0_m=0.0, dr_m=0.05, sound_speed=1500.0,
        bearing_rad=np.linspace(-0.78, 0.78, beams).tolist(),
    )  # fmt: skip


def our_chain(name: str, ping: Ping) -> Task:
    """Return our whole chain, messages included."""
    chain = Chain(PipelineSettings(stage=(EQUALIZE, *CHAINS[name], DETECT)))
    return lambda: chain.process(ping)


SKIMAGE_MEDIANS = {"median 9": (1, 9), "median 5": (1, 5), "median 3x9": (3, 9)}


def cv2_filters() -> dict[str, Filter]:
    """Return the filters that OpenCV has, by the name of the chain."""
    mirror = cv2.BORDER_REFLECT_101
    fir, across, one = both_sides(9, 0.1), both_sides(3, 0.4), np.ones(1, np.float32)
    gauss, gauss_across = (cv2.getGaussianKernel(n, s, cv2.CV_32F) for n, s in ((17, 2.5), (7, 0.7)))
    disc = np.ones((1, 9), np.uint8)
    return {
        "FIR 9": lambda x: cv2.sepFilter2D(x, cv2.CV_32F, fir, one, borderType=mirror),
        "box 9": lambda x: cv2.blur(x, (9, 1), borderType=mirror),
        "FIR 3x9": lambda x: cv2.sepFilter2D(x, cv2.CV_32F, fir, across, borderType=mirror),
        "box 3x9": lambda x: cv2.blur(x, (9, 3), borderType=mirror),
        "Gaussian 2.5": lambda x: cv2.sepFilter2D(x, cv2.CV_32F, gauss, one, borderType=mirror),
        "Gaussian 2.5 x 0.7": lambda x: cv2.sepFilter2D(x, cv2.CV_32F, gauss, gauss_across, borderType=mirror),
        "FIR 9, opening 0.45 m": lambda x: cv2.morphologyEx(
            cv2.sepFilter2D(x, cv2.CV_32F, fir, one, borderType=mirror), cv2.MORPH_OPEN, disc
        ),
    }


def scipy_filters() -> dict[str, Filter]:
    """Return the filters that scipy has, by the name of the chain."""
    fir, across = both_sides(9, 0.1), both_sides(3, 0.4)
    pole = float(np.exp(-1.0 / 3.0))
    along = partial(ndimage.correlate1d, axis=1, mode="mirror")
    return {
        "FIR 9": lambda x: along(x, fir),
        "box 9": lambda x: ndimage.uniform_filter1d(x, 9, 1, mode="mirror"),
        "median 9": lambda x: ndimage.median_filter(x, (1, 9), mode="mirror"),
        "Wiener 9": lambda x: signal.wiener(x, (1, 9)),
        "FIR 3x9": lambda x: ndimage.correlate1d(along(x, fir), across, 0, mode="mirror"),
        "box 3x9": lambda x: ndimage.uniform_filter(x, (3, 9), mode="mirror"),
        "median 5": lambda x: ndimage.median_filter(x, (1, 5), mode="mirror"),
        "median 3x9": lambda x: ndimage.median_filter(x, (3, 9), mode="mirror"),
        "Wiener 3x9": lambda x: signal.wiener(x, (3, 9)),
        "Gaussian 2.5": lambda x: ndimage.gaussian_filter1d(x, 2.5, 1, mode="mirror", truncate=3.2),
        "Gaussian 2.5 x 0.7": lambda x: ndimage.gaussian_filter(x, (0.7, 2.5), mode="mirror", truncate=3.2),
        "IIR 3": lambda x: signal.filtfilt([1.0 - pole], [1.0, -pole], x, axis=1),
        "FIR 9, opening 0.45 m": lambda x: ndimage.grey_opening(along(x, fir), (1, 9)),
    }


def both_sides(taps: int, cutoff: float) -> Floats32:
    """Return all weights of our low-pass, (taps,)."""
    half = lowpass_weights(taps, cutoff)
    return np.concatenate((half[:0:-1], half)).astype(np.float32)


def their_chains(name: str, ping: Ping) -> dict[str, Task]:
    """Return the same chain by each public library that has the filter."""
    frame = np.frombuffer(ping.data, np.uint8).reshape(ping.beams, ping.samples)
    by_cv2, by_scipy = cv2_filters(), scipy_filters()
    tasks: dict[str, Task] = {"scipy": lambda: label_scipy(by_scipy[name](equalized(frame)))}
    tasks["scikit-image"] = lambda: label_skimage(by_scipy[name](equalized(frame)))
    if name in SKIMAGE_MEDIANS:
        footprint = np.ones(SKIMAGE_MEDIANS[name])
        tasks["scikit-image"] = lambda: label_skimage(
            skimage_filters.median(equalized(frame), footprint, mode="mirror")
        )
    if name in by_cv2:
        tasks["OpenCV"] = lambda: label_cv2(by_cv2[name](equalized(frame)))
    return tasks


def equalized(frame: Bytes) -> Image:
    """Return the frame over its mean at each range."""
    image = frame.astype(np.float32)
    image /= image.mean(axis=0)
    return np.asarray(image)


def levels(image: Image) -> tuple[float, float]:
    """Return the low and the high level, of every 29th cell as ours are."""
    middle, upper = np.quantile(image.ravel()[::29], (0.5, 0.8413))
    return float(middle + 2.5 * (upper - middle)), float(middle + 6.0 * (upper - middle))


def label_scipy(image: Image) -> list[Any]:
    """Return the boxes of the regions above the low level that reach the high one."""
    low, high = levels(image)
    labels, _ = ndimage.label(image > low, np.ones((3, 3)))
    kept = np.unique(labels[image > high])
    boxes = ndimage.find_objects(labels)
    return [boxes[k - 1] for k in kept]


def label_skimage(image: Image) -> list[Any]:
    """Return the region properties, 4-connected, as scikit-image's hysteresis is."""
    mask = skimage_filters.apply_hysteresis_threshold(image, *levels(image))
    return [region.bbox for region in skimage_measure.regionprops(skimage_measure.label(mask))]


def label_cv2(image: Image) -> list[Any]:
    """Return the boxes of the regions above the low level that reach the high one."""
    low, high = levels(image)
    _, labels, stats, _ = cv2.connectedComponentsWithStats((image > low).astype(np.uint8), connectivity=8)
    return [stats[k] for k in np.unique(labels[image > high])]


def medians_ms(tasks: dict[str, Task], rounds: int) -> dict[str, float]:
    """Return the median time of each task; they take turns."""
    spent: dict[str, list[float]] = {name: [] for name in tasks}
    for task in tasks.values():
        task()
    for _ in range(rounds):
        for name, task in tasks.items():
            for _ in range(SETTLING):
                task()
            for _ in range(TIMED):
                began = time.perf_counter()
                task()
                spent[name].append(1e3 * (time.perf_counter() - began))
    return {name: float(np.median(times)) for name, times in spent.items()}


def table_of_chains(beams: int, rounds: int) -> None:
    """Print one line a chain."""
    ping = made_up_ping(beams)
    print(f"\nms from {beams} x 2000 uint8 to detections, median of {rounds} interleaved runs, one core")
    print(f"{'equalize, filter, detect':26}{'target':>8}{'ODS':>8}{'OpenCV':>8}{'scipy':>8}{'scikit-image':>14}")
    for name in CHAINS:
        times = medians_ms({"ODS": our_chain(name, ping)} | their_chains(name, ping), rounds)
        target = {60: TARGETS_MS, 512: {"FIR 9": 0.9}}[beams].get(name)
        cells = [f"{target:8.2f}" if target else " " * 8, f"{times['ODS']:8.3f}"]
        cells += [f"{times[other]:8.2f}" if other in times else " " * 8 for other in ("OpenCV", "scipy")]
        print(f"{name:26}{''.join(cells)}{times['scikit-image']:14.2f}")


def table_2() -> None:
    """Print table 2 of the paper beside ours: stages by how much longer the chain gets with them."""
    ping = made_up_ping(60)
    chains = {
        "detection": Chain(PipelineSettings(stage=(DETECT,))),
        "filtering": Chain(PipelineSettings(stage=(FIR_9, DETECT))),
        "total": Chain(PipelineSettings(stage=(EQUALIZE, FIR_9, DETECT))),
    }
    times = medians_ms({name: partial(chain.process, ping) for name, chain in chains.items()}, 2 * ROUNDS)
    ours = {
        "detection": times["detection"],
        "filtering": max(0.0, times["filtering"] - times["detection"]),
        "equalization": max(0.0, times["total"] - times["filtering"]),
        "total": times["total"],
    }
    print("\n[SSIE] table 2, seconds an image           MATLAB   C, 68040        ODS     C / ODS")
    for name, matlab, c in TABLE_2:
        print(f"{name:40}{matlab:9.2f}{c:11.2f}{1e-3 * ours[name]:11.6f}{c / max(1e-3 * ours[name], 1e-9):12,.0f}")


def table_of_attention(beams: int, rounds: int) -> None:
    """Print what focus of attention saves, as the mean over all turns, and what a look at an object then finds."""
    ping = made_up_ping(beams)
    print(
        f"\nfocus of attention, {beams} x 2000: near {PAPER['near_m']:.0f} m always, far every 4th, 2 samples to 1; ms"
    )
    print(f"{'chain':18}{'all':>8}{'2 to 1':>8}{'rings':>8}{'both':>8}{'speed-up':>10}  found, range rms: all, both")
    for name, stages in ATTENTION_CHAINS.items():
        chains = {name: Chain(PipelineSettings(stage=stages, attention=how)) for name, how in ATTENTION.items()}
        times = medians_ms({name: partial(_four_pings, chain, ping) for name, chain in chains.items()}, rounds)
        cells = "".join(f"{times[name] / 4.0:8.3f}" for name in ATTENTION)
        scores = [f"{share:4.0%} {1e3 * rms:4.0f} mm" for share, rms in map(_looks, (chains["all"], chains["both"]))]
        print(f"{name:18}{cells}{times['all'] / times['both']:10.1f}  {', '.join(scores) if beams == 60 else ''}")


def _four_pings(chain: Chain, ping: Ping) -> None:
    for _ in range(4):
        chain.process(ping)


def _looks(chain: Chain) -> tuple[float, float]:
    """Return the share of weak objects found, of those looked at, and the standard deviation of their range, m."""
    places = [(12, 8.0), (30, 16.0), (45, 31.0), (20, 52.0), (50, 68.0), (35, 90.0)]
    looked, errors = 0, []
    for number in range(200):
        result = chain.process(made_up_ping(60, seed=number, objects=places, intensity=OBJECT_INTENSITY))
        for beam, range_m in places:
            processed = result.processed_ranges_m
            if processed and not any(begin <= range_m < stop for begin, stop in processed):
                continue
            looked += 1
            away = [
                d.range_m - range_m
                for d in result.detections
                if abs(d.range_m - range_m) < 2.0 and abs(d.bearing_rad / 1.56 * 59 + 29.5 - beam - 1) < 3.0
            ]
            errors += [min(away, key=abs)] if away else []
    return len(errors) / looked, float(np.std(errors))


START = """
import time
began = time.perf_counter()
import ods.pipeline.service
imported = time.perf_counter()
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.warm_up import made_up_ping, warm_up
warm_up(PipelineSettings())
Chain(PipelineSettings()).process(made_up_ping("u1", "linear", 0.0, 0.05))
print(imported - began, time.perf_counter() - began)
"""


def table_of_start(rounds: int) -> None:
    """Print how long the pipeline process takes to import, and to its first ping, when the cache is warm.

    The cache is one of its own: where Python is not to write any, all that is measured is how long it compiles.
    """
    spent = []
    with TemporaryDirectory() as cache:
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": cache, "PYTHONDONTWRITEBYTECODE": ""}
        for _ in range(rounds + 1):
            began = time.perf_counter()
            done = subprocess.run(
                [sys.executable, "-c", START], capture_output=True, text=True, check=True, env=environment
            )
            spent.append([*map(float, done.stdout.split()), time.perf_counter() - began])
    imported, first, whole = np.median(spent[1:], axis=0)  # the first one fills the cache
    print("\nstart of the pipeline process, default chain, cache warm, s")
    print(f"import {imported:.2f} (target 0.6); to the first ping's detections {first:.2f} (target 1),", end=" ")
    print(f"with the interpreter's own start {whole:.2f}")


def main() -> None:
    """Print all tables."""
    cv2.setNumThreads(1)
    table_of_chains(60, ROUNDS)
    table_of_chains(512, ROUNDS // 6)
    table_of_attention(60, ROUNDS)
    table_of_attention(512, ROUNDS // 6)
    table_of_start(5)
    table_2()


if __name__ == "__main__":
    main()
