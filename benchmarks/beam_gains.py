"""`python -m benchmarks.beam_gains`: false echoes in images of pure speckle whose beams differ in gain.

Rayleigh speckle, 60 x 2000, 8-bit linear, no object. Gains are those of one beam in the middle, or drawn for all beams
anew for each set, normal or uniform; a beam of +20 dB is beyond full scale of 8 bits, not of 16. Beside the default
chain the same one without `equalize.beam_gain`.
"""

import argparse

import numpy as np

from ods.base.arrays import AnyArray, Floats
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import DEFAULT_STAGES, PipelineSettings, StageTable

BEAMS, SAMPLES = 60, 2000
SETS = 5
"""Draws of random gains; each goes through a chain of its own."""
ONE = (-20.0, -10.0, -6.0, -3.0, 0.0, 1.0, 3.0, 6.0, 10.0, 20.0)
RMS = (0.5, 1.0, 2.0, 3.0, 6.0)
UNIFORM = (10.0, 20.0)
WITHOUT = tuple(stage for stage in DEFAULT_STAGES if stage["use"] != "equalize.beam_gain")


def gains_of(kind: str, size_db: float, rng: np.random.Generator) -> Floats:
    """Return the (beams,) gains, dB: `one` beam, `rms` normal or `uniform` up to +- size_db."""
    if kind == "one":
        return np.where(np.arange(BEAMS) == BEAMS // 2, size_db, 0.0)
    drawn = rng.normal(0.0, size_db, BEAMS) if kind == "rms" else rng.uniform(-size_db, size_db, BEAMS)
    return np.asarray(drawn)


def ping_of(amplitude: Floats, bits: int, number: int) -> Ping:
    """Return the ping of amplitudes (beams, samples) of mean 1 as linear counts."""
    top, mean = (255.0, 30.0) if bits == 8 else (65535.0, 3000.0)
    counts: AnyArray = np.minimum(mean * amplitude, top).astype(np.uint8 if bits == 8 else np.uint16)
    return Ping(
        seq=number, ping_number=number, t_ns=number * 150_000_000, t_rx_ns=0, utc_ns=0, beams=BEAMS, samples=SAMPLES,
        dtype="u1" if bits == 8 else "u2", data=counts.tobytes(), bearing_rad=np.linspace(-0.78, 0.78, BEAMS).tolist(),
        range0_m=0.0, dr_m=0.05, sound_speed=1500.0,
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


if __name__ == "__main__":
    main()
