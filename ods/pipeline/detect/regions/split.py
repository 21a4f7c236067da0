"""Splitting of merged objects: two crests with a valley between them are two echoes."""

from itertools import pairwise

import numpy as np

from ods.base.arrays import Image
from ods.compiled import native
from ods.pipeline.detect.background.rise import ThresholdRise
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import RUN, Runs, sorted_runs


def split_regions(image: Image, runs: Runs, valley_db: float, low: float, smallest: int, fan: Fan) -> tuple[Runs, int]:
    """Return the runs, of regions 1, 2, ..., split where a valley of `valley_db` under the crest parts them.

    What remains connected of a region that far under its crest, in pieces of at least `smallest` cells, is a core; when
    there are several, each cell goes to the core whose middle is nearest in metres. An echo weaker than that by its
    neighbour is not parted from it.
    """
    out: list[Runs] = []
    for region in range(1, int(runs["region"].max()) + 1):
        part = runs[runs["region"] == region].copy()
        level = 10.0 ** (-valley_db / 20.0) * max(float(image[b, i:j].max()) for b, i, j, _ in part.tolist())
        cores = _cores(image, part, level, smallest) if level > low else []
        pieces = [part] if len(cores) < 2 else _shared_out(part, cores, fan)
        for piece in pieces:
            piece["region"] = len(out) + 1
            out.append(piece)
    return sorted_runs(np.concatenate(out)), len(out)


def _cores(image: Image, runs: Runs, level: float, smallest: int) -> list[tuple[float, float]]:
    """Return the (beam, column) middles of the pieces of one region above `level`."""
    beam, column = int(runs["beam"].min()), int(runs["first"].min())
    crop = np.zeros((int(runs["beam"].max()) + 1 - beam, int(runs["stop"].max()) - column), np.float32)
    for b, first, stop, _ in runs.tolist():
        crop[b - beam, first - column : stop - column] = image[b, first:stop]
    found = np.empty(crop.size, RUN)
    rule = (level, level, 1, smallest, crop.size, ThresholdRise.none())
    found = found[: native.find_regions(crop, rule, found, np.zeros(crop.shape, np.bool_))]
    cores = []
    for k in np.unique(found["region"]):
        piece = found[found["region"] == k]
        length = piece["stop"] - piece["first"]
        middle = 0.5 * (piece["first"] + piece["stop"] - 1)
        cores.append((float(beam + np.average(piece["beam"], weights=length)),
                      float(column + np.average(middle, weights=length))))  # fmt: skip
    return cores


def _shared_out(runs: Runs, cores: list[tuple[float, float]], fan: Fan) -> list[Runs]:
    """Return the runs of each core: each cell goes to the nearest one."""
    number = np.arange(len(fan.bearing_rad))
    at_range = [float(np.interp(column, np.arange(fan.samples), fan.range_m)) for _, column in cores]
    at_bearing = [float(np.interp(beam, number, fan.bearing_rad)) for beam, _ in cores]
    pieces: list[list[tuple[int, int, int, int]]] = [[] for _ in cores]
    for b, first, stop, _ in runs.tolist():
        away = fan.range_m[first:stop]
        distance = [np.hypot(away - r, r * (fan.bearing_rad[b] - a)) for r, a in zip(at_range, at_bearing, strict=True)]
        owner = np.argmin(distance, axis=0)
        borders = [0, *(np.flatnonzero(np.diff(owner)) + 1).tolist(), stop - first]
        for i, j in pairwise(borders):
            pieces[int(owner[i])].append((b, first + i, first + j, 0))
    return [np.array(piece, RUN) for piece in pieces if piece]
