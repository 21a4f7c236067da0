"""Detections of the default chain at its own levels, on images that were not used for any choice."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from ods.assess.detection.measure import score_of, stability
from ods.assess.detection.metrics import Score
from ods.assess.images.held_out import held_out_images
from ods.assess.images.labels import read_labels
from ods.assess.images.tank import tank_images
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.sonar_link.files.opening import open_pings

CHECK_SEED = 909
"""Of the look-alikes that nothing was chosen on."""


def check_look_alikes(count: int) -> Iterator[str]:
    """Yield what is found on `count` look-alikes of each of two models."""
    looks = {"tank look-alikes": tank_images(count, CHECK_SEED), "held-out": held_out_images(count, CHECK_SEED)}
    for name, images in looks.items():
        yield f"default chain on {len(images)} {name}: {_figures(score_of(PipelineSettings(), images))}"


def check_recording(recording: Path, labels: Path) -> Iterator[str]:
    """Yield what is found on the labelled frames of a recording. Raises OdsError."""
    pings = open_pings(recording).pings
    clusters, again = steadiness(pings)
    score = score_of(PipelineSettings(), read_labels(labels, pings))
    yield f"{recording}, labelled by eye: {_figures(score)}"
    yield f"{recording}: {clusters:.1f} clusters a frame, {again:.0%} of them again in the next"


def steadiness(pings: Sequence[Ping]) -> tuple[float, float]:
    """Return clusters a frame of the default chain, and the share of them that the next frame shows again."""
    chain = Chain(PipelineSettings())
    return stability([chain.process(ping) for ping in pings])


def _figures(score: Score) -> str:
    share = f"{score.found} of {score.targets} ({score.detection_probability:.1%})"
    return f"found {share}, {score.false_per_image:.1f} unlabelled clusters a frame"
