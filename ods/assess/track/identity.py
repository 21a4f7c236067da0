"""HOTA and IDF1: how well tracks hold both places and identities, as in TrackEval, over the scans of a run. Pure.

HOTA: Luiten, Osep, Dendorfer, Torr, Geiger, Leal-Taixe, Leibe: HOTA: a higher order metric for evaluating multi-object
tracking, IJCV 129, 2021. IDF1: Ristani, Solera, Zou, Cucchiara, Tomasi: Performance measures and a data set for
multi-target, multi-camera tracking, ECCV workshops 2016. A point's similarity to another falls from 1 at no distance
to 0 at `ZERO_M`, as TrackEval's of points does.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints

ZERO_M = 6.0
"""Distance, m, at which a track has nothing of an object: an identity is held, at a similarity of 0.5, within half."""
ALPHAS = np.arange(1, 20) / 20.0
"""Similarities from which on a pair is one: HOTA is the mean over them."""
ID_SIMILARITY = 0.5
"""The one for IDF1."""
ROUNDING = 1e-12


class Frame(NamedTuple):
    """One scan."""

    objects: Ints
    """(n,) numbers, from 0, of the objects that have to be tracked."""
    tracks: Ints
    """(m,) numbers, from 0, of the tracks that count."""
    similarity: Floats
    """(n, m) and how near each pair is, 0 to 1."""


class Hota(NamedTuple):
    """Means over `ALPHAS`."""

    hota: float
    """Of the geometric mean of the next two."""
    detection: float
    """DetA: pairs over pairs, missed and false ones."""
    association: float
    """AssA: the same of the two trajectories of each pair, mean of the pairs."""


def similarity(distance: Floats) -> Floats:
    """Return the similarity of pairs whose distances, m, are of any shape."""
    return np.maximum(0.0, 1.0 - distance / ZERO_M)


def hota(frames: Sequence[Frame]) -> Hota:
    """Return HOTA of a run; NaN of one without objects and tracks."""
    objects, tracks = _lengths(frames)
    if objects.sum() + tracks.sum() == 0:
        return Hota(np.nan, np.nan, np.nan)
    together = objects[:, None] + tracks[None]
    overlap = _overlap(frames, len(objects), len(tracks))
    alignment = overlap / np.maximum(together - overlap, 1.0)
    pairs = np.zeros((len(ALPHAS), len(objects), len(tracks)))
    for frame in frames:
        mine, theirs, near = _matched(frame, alignment)
        for row, alpha in zip(pairs, ALPHAS, strict=True):
            enough = near >= alpha - ROUNDING
            row[mine[enough], theirs[enough]] += 1.0
    found = pairs.sum(axis=(1, 2))
    detection = found / np.maximum(objects.sum() + tracks.sum() - found, 1.0)
    jaccard = pairs / np.maximum(together - pairs, 1.0)
    association = (pairs * jaccard).sum(axis=(1, 2)) / np.maximum(found, 1.0)
    each = np.sqrt(detection * association)
    return Hota(float(each.mean()), float(detection.mean()), float(association.mean()))


def idf1(frames: Sequence[Frame]) -> float:
    """Return IDF1 of a run: one track an object and one object a track, so that most of their scans agree; or NaN."""
    from scipy.optimize import linear_sum_assignment  # 20 MB: only where lists are judged

    objects, tracks = _lengths(frames)
    held = np.zeros((len(objects), len(tracks)))
    for frame in frames:
        mine, theirs = np.nonzero(frame.similarity >= ID_SIMILARITY)
        held[frame.objects[mine], frame.tracks[theirs]] += 1.0
    # the assignment of least missed and false ones is that of most held: all others cost the same whoever has them
    chosen = linear_sum_assignment(held, maximize=True)
    total = objects.sum() + tracks.sum()
    return float(2.0 * held[chosen].sum() / total) if total else np.nan


def _lengths(frames: Sequence[Frame]) -> tuple[Floats, Floats]:
    """Return in how many scans each object and each track is."""
    return _counts([frame.objects for frame in frames]), _counts([frame.tracks for frame in frames])


def _counts(numbers: Sequence[Ints]) -> Floats:
    return np.bincount(np.concatenate([np.zeros(0, np.int64), *numbers])).astype(np.float64)


def _overlap(frames: Sequence[Frame], objects: int, tracks: int) -> Floats:
    """Return (objects, tracks) in how many scans, weighted, both may be one, whatever else is near."""
    overlap = np.zeros((objects, tracks))
    for frame in frames:
        near = frame.similarity
        rivals = near.sum(axis=0)[None] + near.sum(axis=1)[:, None] - near
        overlap[np.ix_(frame.objects, frame.tracks)] += near / np.maximum(rivals, ROUNDING)
    return overlap


def _matched(frame: Frame, alignment: Floats) -> tuple[Ints, Ints, Floats]:
    """Return the pairs of a scan that serve association best, and their similarities."""
    from scipy.optimize import linear_sum_assignment

    score = alignment[np.ix_(frame.objects, frame.tracks)] * frame.similarity
    rows, columns = linear_sum_assignment(score, maximize=True)
    return frame.objects[rows], frame.tracks[columns], frame.similarity[rows, columns]
