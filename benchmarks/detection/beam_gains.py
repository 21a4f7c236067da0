"""`benchmarks.detection.beam_gains`: false echoes in speckle whose beams differ in gain, and bodies found in it.

Rayleigh speckle, 60 x 2000, 8- and 16-bit linear. Gains are those of one beam in the middle, or drawn for all beams
anew for each set, normal or uniform; a beam of +20 dB is beyond full scale of 8 bits, not of 16. Beside the default
chain the same one without `equalize.beam_gain`. The last table has the share of bodies of 1 m, 12 dB over the speckle,
that are found.
"""

import argparse

import numpy as np

from ods.base.arrays import AnyArray, Floats
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import DEFAULT_STAGES, PipelineSettings, StageTable

BEAMS, SAMPLES = 60, 2000
DR_M, HALF_RAD = 0.05, 0.78
SETS = 5
"""Draws of random gains; each goes through a chain of its own."""
ONE = (-20.0, -10.0, -6.0, -3.0, 0.0, 1.0, 3.0, 6.0, 10.0, 20.0)
RMS = (0.5, 1.0, 2.0, 3.0, 6.0)
UNIFORM = (10.0, 20.0)
BODIES = 12
BODY_M, BODY_DB = 1.0, 12.0
BODY_GAINS = (3.0, 6.0, 10.0, 20.0)
"""Uniform up to +- so many dB, for the bodies."""
FOUND_M = 1.0
"""A detection so near a body's middle finds it."""
WITHOUT = tuple(stage for stage in DEFAULT_STAGES if stage["use"] != "equalize.beam_gain")


def gains_of(kind: str, size_db: float, rng: np.random.Generator) -> Floats:
    """Return the (beams,) gains, dB: `one` beam, `rms` normal or `uniform` up to +- size_db."""
    if kind == "one":
        return np.where(np.arange(BEAMS) == BEAMS // 2, size_db, 0.0)
    drawn = rng.normal(0.0, size_db, BEAMS) if kind == "rms" else rng.uniform(-size_db, size_db, BEAMS)
    return np.asarray(drawn)


def ping_of(amplitude: Floats, bits: int, number: int) -> Ping:
    """Return the ping of amplitudes (beams, samples) of mean 1 as linear counts."""
    bearings = np.linspace(-HALF_RAD, HALF_RAD, BEAMS).tolist()
    top, mean = (255.0, 30.0) if bits == 8 else (65535.0, 3000.0)
    counts: AnyArray = np.minimum(mean * amplitude, top).astype(np.uint8 if bits == 8 else np.uint16)
    return Ping(
        seq=number, ping_number=number, t_ns=number * 150_000_000, t_rx_ns=0, utc_ns=0, beams=BEAMS, samples=SAMPLES,
        dtype="u1" if bits == 8 else "u2", data=counts.tobytes(), bearing_rad=bearings,
        range0_m=0.0, dr_m=DR_M, sound_speed=1500.0,
    )  # fmt: skip


def false_echoes(stages: tuple[StageTable, ...], kind: str, size_db: float, bits: int, images: int) -> float:
    """Return the detections an image of nothing but speckle."""
    rng, found = np.random.default_rng(7), 0
    for _ in range(SETS):
        chain = Chain(PipelineSettings(stage=stages, min_range_m=0.0))
        gain = 10.0 ** (gains_of(kind, size_db, rng) / 20.0)
        for number in range(images):
            speckle = rng.rayleigh(np.sqrt(2.0 / np.pi), (BEAMS, SAMPLES))
            found += len(chain.process(ping_of(gain[:, None] * speckle, bits, number)).detections)
    return found / (SETS * images)


def bodies_found(stages: tuple[StageTable, ...], size_db: float, images: int) -> float:
    """Return the share of bodies that are found where gains are uniform up to +- size_db."""
    rng, found = np.random.default_rng(11), 0
    chain = Chain(PipelineSettings(stage=stages, min_range_m=0.0))
    gain = 10.0 ** (gains_of("uniform", size_db, rng) / 20.0)
    ranges, bearings = DR_M * np.arange(SAMPLES), np.linspace(-HALF_RAD, HALF_RAD, BEAMS)
    north, east = ranges * np.cos(bearings)[:, None], ranges * np.sin(bearings)[:, None]
    for number in range(images):
        r, b = rng.uniform(8.0, 35.0, BODIES), rng.uniform(-0.9, 0.9, BODIES) * HALF_RAD
        where = np.column_stack([r * np.cos(b), r * np.sin(b)])
        inside = sum(np.hypot(north - n, east - e) < BODY_M / 2.0 for n, e in where) > 0
        level = np.where(inside, 10.0 ** (BODY_DB / 20.0), 1.0)
        speckle = rng.rayleigh(np.sqrt(2.0 / np.pi), (BEAMS, SAMPLES))
        seen = chain.process(ping_of(gain[:, None] * level * speckle, 8, number)).detections
        places = np.array([[d.range_m * np.cos(d.bearing_rad), d.range_m * np.sin(d.bearing_rad)] for d in seen])
        if len(places):
            found += int((np.hypot(*(places[:, None] - where).T).min(axis=1) < FOUND_M).sum())
    return found / (BODIES * images)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=int, default=40, help="for each of 5 sets of gains")
    images = parser.parse_args().images
    print(f"false echoes an image, {SETS} x {images} images")
    print(f"{'beam gains':20}{'8 bits':>10}{'without':>10}{'16 bits':>10}{'without':>10}")
    cases = [(stages, bits) for bits in (8, 16) for stages in (DEFAULT_STAGES, WITHOUT)]
    for kind, sizes in (("one", ONE), ("rms", RMS), ("uniform", UNIFORM)):
        for size_db in sizes:
            cells = "".join(f"{false_echoes(stages, kind, size_db, bits, images):10.3f}" for stages, bits in cases)
            print(f"{kind:10}{size_db:+6.1f} dB {cells}", flush=True)
    print(f"share found of {BODIES} bodies of {BODY_M:g} m, {BODY_DB:g} dB, in each of {images} images, 8 bits")
    for size_db in BODY_GAINS:
        cells = "".join(f"{bodies_found(stages, size_db, images):10.3f}" for stages in (DEFAULT_STAGES, WITHOUT))
        print(f"uniform   {size_db:+6.1f} dB {cells}", flush=True)


if __name__ == "__main__":
    main()
