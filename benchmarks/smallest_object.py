"""The default chain against itself with columns of one sample: what one setting for its windows costs and saves.

`--size M` sets `pipeline.smallest_object_m`; `--real RECORDING LABELS` adds labelled frames. The same images for both.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.heavy_tails import PLACES, SHAPE, ping_of
from ods.assess.detection.measure import milliseconds, score_of
from ods.assess.images.held_out import held_out_images
from ods.assess.images.labels import read_labels
from ods.assess.images.sea import sea_images
from ods.assess.images.tank import tank_images
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import AttentionSettings, PipelineSettings
from ods.sonar_link.files.opening import open_pings

BODIES = {(2, 24): (3.0, 4.0, 5.0), (1, 6): (7.0, 9.0, 11.0)}
"""Beams and samples of bodies, and how many dB they are over speckle."""


def bodies(size: tuple[int, int], body_db: float, images: int) -> list[Ping]:
    """Return images of speckle with four bodies each."""
    intensity = np.ones(SHAPE)
    for beam, sample in PLACES:
        intensity[beam : beam + size[0], sample : sample + size[1]] += 10.0 ** (body_db / 10.0)
    return [ping_of(intensity, np.random.default_rng([k, size[1]])) for k in range(images)]


def found_share(chain: Chain, pings: list[Ping], size: tuple[int, int]) -> float:
    """Return the share of the bodies that a region touches."""
    found = 0
    for ping in pings:
        mask = np.zeros(SHAPE, np.int32)
        chain.process(ping, mask)
        found += sum(bool(mask[b : b + size[0], s : s + size[1]].any()) for b, s in PLACES)
    return found / len(pings) / len(PLACES)


def on_speckle(settings: PipelineSettings, images: int) -> Iterator[tuple[str, str]]:
    """Yield what is found in speckle, and of bodies over it."""
    chain = Chain(settings)
    empty = [ping_of(np.ones(SHAPE), np.random.default_rng([k, 1])) for k in range(2 * images)]
    yield "false echoes an image of speckle", f"{np.mean([len(chain.process(ping).detections) for ping in empty]):.3f}"
    for size, levels in BODIES.items():
        shares = [found_share(chain, bodies(size, body_db, images), size) for body_db in levels]
        name = f"bodies of {size[1]} samples x {size[0]} beams, {', '.join(f'{level:g}' for level in levels)} dB"
        yield name, ", ".join(f"{share:.2f}" for share in shares)


def on_labelled(settings: PipelineSettings, images: int, real: list[tuple[Path, Path]]) -> Iterator[tuple[str, str]]:
    """Yield what is found on labelled images."""
    kinds = {
        f"{2 * images} tank look-alikes, seed 909": tank_images(2 * images, 909),
        f"{2 * images} held-out look-alikes, seeds 909, 202": held_out_images(images, 909)
        + held_out_images(images, 202),
        f"{images} of the sea, seed 99": sea_images(images, 99),
    }
    for recording, labels in real:
        kinds[recording.name] = read_labels(labels, open_pings(recording).pings)
    for name, labelled in kinds.items():
        score = score_of(settings, labelled)
        yield name, f"{score.found} of {score.targets}, {score.false_per_image:.2f}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=int, default=40)
    parser.add_argument("--size", type=float, default=0.0, metavar="M")
    parser.add_argument("--real", type=Path, nargs=2, action="append", default=[], metavar=("RECORDING", "LABELS"))
    args = parser.parse_args()
    both = (
        PipelineSettings(attention=AttentionSettings(subsample=1)),
        PipelineSettings(smallest_object_m=args.size),
    )
    real = [(recording, labels) for recording, labels in args.real]
    columns = [[*on_speckle(each, args.images), *on_labelled(each, args.images, real)] for each in both]
    print("| found; false an image | one sample a column | by the smallest object |\n|---|---|---|")
    for (name, before), (_, now) in zip(*columns, strict=True):
        print(f"| {name} | {before} | {now} |")
    spent = milliseconds(both, sea_images(1, 99)[0].ping, args.images)
    print(f"| ms, 60 x 2000, log8, medians in turns | {spent[0]:.3f} | {spent[1]:.3f} |")


if __name__ == "__main__":
    main()
