"""Runs settings over labelled images: accuracy at one false alarm an image, what filters do, and time."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import msgspec
import numpy as np

from ods.assess.detection.chains import Setting
from ods.assess.detection.metrics import (
    Score,
    at_false_alarms,
    edge_preservation,
    interval_at_false_alarms,
    nearest_score,
    noise_suppression_db,
)
from ods.assess.detection.tap import filtered
from ods.assess.images.labelled import LabelledImage
from ods.base.arrays import Floats, Floats32
from ods.messages import Detection, Detections, Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings, StageTable

SAME = 0.02
"""Share of the sector that an echo may move from frame to frame and count as the same."""
SWEEP_CELLS = 1_000_000
"""Of speckle, that detectors learn from: a threshold that is swept needs no exact rate."""
NEAR_AN_OBJECT = 2.0
"""Cells whose expected level is above this multiple of their range's median show an object or its mirror images."""


@dataclass(frozen=True)
class Accuracy:
    """Detection performance of a setting at a fixed number of false alarms per image."""

    detection_probability: float
    position_error_m: float
    """Median; nan where nothing was found or no circle is known."""
    radius_error: float
    """Median of the relative error's size; nan likewise."""
    interval: tuple[float, float] = (float("nan"), float("nan"))
    """Of the detection probability, by bootstrap over the images."""


@dataclass(frozen=True)
class SettingRow:
    """Figures of one setting."""

    name: str
    ms: float
    """Median for one simulated image, everything included."""
    sea: Accuracy
    tank: Accuracy
    noise_db: float
    """Noise suppression of its filters."""
    edges: float
    """Their edge preservation."""


def accuracy_of(setting: Setting, images: Sequence[LabelledImage], false_alarms: float) -> Accuracy:
    """Sweep the threshold of a setting over the images, to `false_alarms` an image."""
    scores = [score_of(settings, images) for settings in setting.settings]
    nearest = scores[nearest_score(scores, false_alarms)]
    return Accuracy(
        at_false_alarms(scores, false_alarms),
        _median(nearest.position_error_m),
        _median(np.abs(nearest.radius_error)),
        interval_at_false_alarms(scores, false_alarms),
    )


def score_of(settings: PipelineSettings, images: Sequence[LabelledImage]) -> Score:
    """Return the score of one chain. With attention in turns, an image is what one whole turn over it finds."""
    chain, score = Chain(settings, learnt_cells=SWEEP_CELLS), Score()
    for image in images:
        found: list[Detection] = []
        for turn in range(turns_of(settings)):
            ping = msgspec.structs.replace(image.ping, seq=turn, ping_number=turn)
            new = chain.process(ping).detections
            found += [d for d in new if turn == 0 or d.range_m > settings.attention.near_m]
        score.count_image(found, image.targets)
    return score


def turns_of(settings: PipelineSettings) -> int:
    """Return after how many pings everything has been looked at."""
    return settings.attention.every if settings.attention.near_m > 0.0 else 1


def _median(values: Sequence[float] | Floats) -> float:
    return float(np.median(values)) if len(values) else float("nan")


def filter_figures(filters: Sequence[StageTable], images: Sequence[LabelledImage]) -> tuple[float, float]:
    """Return noise suppression, dB, and edge preservation of a chain of filters: means over the images with a mean
    image. Equalizers count as given: both images pass through them, edges are those of the mean image behind them."""
    equalizers = [stage for stage in filters if stage["use"].startswith("equalize.")]
    noise, edges = [], []
    for image in images:
        if image.mean is None:
            continue
        before, after = filtered(equalizers, image.ping), filtered(filters, image.ping)
        clean = filtered(equalizers, _without_speckle(image, image.mean))
        quiet = clean < NEAR_AN_OBJECT * np.median(clean, axis=0)
        noise.append(noise_suppression_db(before, after, quiet))
        edges.append(edge_preservation(clean, after))
    return (float(np.mean(noise)), float(np.mean(edges))) if noise else (float("nan"), float("nan"))


def _without_speckle(image: LabelledImage, mean: Floats32) -> Ping:
    return msgspec.structs.replace(image.ping, dtype="f4", data=mean.tobytes(), scale="linear", scale_factor=1.0)


def milliseconds(settings: Sequence[PipelineSettings], ping: Ping, rounds: int) -> list[float]:
    """Return the median time of each chain for one ping, measured in turns, so that a busy moment harms them alike."""
    chains = [(Chain(each, learnt_cells=SWEEP_CELLS), turns_of(each)) for each in settings]
    spent = np.empty((rounds, len(chains)))
    for turn in range(-1, rounds):  # the first time fills buffers, the next one takes its place
        for index, (chain, turns) in enumerate(chains):
            began = time.perf_counter_ns()
            for number in range(turns):
                chain.process(msgspec.structs.replace(ping, seq=number, ping_number=number))
            spent[max(turn, 0), index] = (time.perf_counter_ns() - began) / turns
    return [float(value) for value in np.median(spent, axis=0) / 1e6]


def stability(frames: Sequence[Detections]) -> tuple[float, float]:
    """Return clusters a frame, and the share of them that the next frame shows again; nan where there are none.

    Again is: within `SAME` of the sector's extent in range and in bearing. What is there stays; false alarms of
    speckle do not. Frames of a sonar that hardly moves.
    """
    kept, total = 0, 0
    for now, after in pairwise(frames):
        sector = now.sector
        reach_m = SAME * (sector.range_max_m - sector.range_min_m)
        reach_rad = SAME * (sector.bearing_max_rad - sector.bearing_min_rad)
        places = [(d.range_m, d.bearing_rad) for d in after.detections]
        total += len(now.detections)
        kept += sum(
            any(abs(d.range_m - r) <= reach_m and abs(d.bearing_rad - b) <= reach_rad for r, b in places)
            for d in now.detections
        )
    clusters = float(np.mean([len(frame.detections) for frame in frames])) if frames else float("nan")
    return clusters, kept / total if total else float("nan")
