"""The pipeline on recorded pings: detections as .npz, JSON lines and masks."""

import itertools
import logging
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from ods.base.arrays import AnyArray, Floats
from ods.base.files.out_file import opened_to_seek
from ods.messages import Detections, Ping
from ods.pipeline.chain import Chain
from ods.pipeline.image.samples.recorded import RegionNumbers
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.watch import Watch

log = logging.getLogger(__name__)

DETECTION_COLUMNS = ("range_m", "bearing_rad", "radius_m", "peak", "mean", "snr_db", "cells")
"""Columns 1 to 7 of `det`; column 0 is the ping's index in the file."""


class PingResult(NamedTuple):
    """Result of one ping of a file."""

    place: int
    """Place in the file, from 0."""
    ping: Ping
    detections: Detections
    mask: RegionNumbers | None
    """(beams, samples) int32, k the k-th detection, when asked for."""


def detect_pings(
    pings: Iterable[Ping],
    settings: PipelineSettings,
    *,
    places: Iterable[int] | None = None,
    masks: bool = False,
    watch: Watch | None = None,
) -> Iterator[PingResult]:
    """Yield the detections of each ping, in order. Raises PluginError, StageError.

    An invalid ping is left out, with a warning that gives the reason; the others keep their index.

    places: where in the file the pings stand, if not one after the other from 0 on; watch: see `Chain`.
    """
    chain = Chain(settings, watch=watch)
    for index, ping in zip(itertools.count() if places is None else places, pings, strict=False):
        mask = np.zeros((ping.beams, ping.samples), np.int32) if masks else None
        try:
            yield PingResult(index, ping, chain.process(ping, mask), mask)
        except PingError as error:
            log.warning("skipped ping %d of the file: %s", index, error)


def detection_table(results: Iterable[PingResult]) -> Floats:
    """Return the (detections, 8) table `det`: ping index, then DETECTION_COLUMNS."""
    rows = [
        [result.place, *(getattr(detection, name) for name in DETECTION_COLUMNS)]
        for result in results
        for detection in result.detections.detections
    ]
    return np.array(rows, np.float64).reshape(-1, 1 + len(DETECTION_COLUMNS))


def save_npz(path: Path, results: Sequence[PingResult]) -> None:
    """Write `det` and, when the results have masks, `mask` (pings, beams, samples) int32.

    Pings that were left out have a mask of zeros. Raises ValueError for masks of pings of different shapes.
    """
    arrays: dict[str, AnyArray] = {"det": detection_table(results)}
    masks = {result.place: result.mask for result in results if result.mask is not None}
    if masks:
        shapes = {mask.shape for mask in masks.values()}
        if len(shapes) > 1:
            raise ValueError(f"mask: the pings differ in shape: {', '.join(map(str, sorted(shapes)))}")
        shape = shapes.pop()
        empty = np.zeros(shape, np.int32)
        arrays["mask"] = np.stack([masks.get(index, empty) for index in range(max(masks) + 1)])
    with opened_to_seek(path) as file:  # a file, as savez appends .npz to a path that lacks it
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]


def json_line(result: PingResult) -> str:
    """Return one ping's detections as one line of JSON: `index` and the fields of `ods.messages.Detections`."""
    return msgspec.json.encode({"index": result.place, **msgspec.structs.asdict(result.detections)}).decode()
