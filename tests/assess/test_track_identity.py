"""HOTA and IDF1 against cases worked by hand."""

import math

import numpy as np
import pytest

from ods.assess.track.identity import Frame, hota, idf1, similarity
from ods.base.arrays import Floats

Scan = tuple[list[int], list[int], list[list[float]]]
"""Objects, tracks, and how near each pair is."""


def run(*scans: Scan) -> list[Frame]:
    return [
        Frame(np.array(objects, np.int64), np.array(tracks, np.int64), _table(near, len(objects), len(tracks)))
        for objects, tracks, near in scans
    ]


def _table(near: list[list[float]], objects: int, tracks: int) -> Floats:
    return np.array(near, np.float64).reshape(objects, tracks)


PERFECT = [([0, 1], [5, 7], [[1.0, 0.0], [0.0, 1.0]])] * 3
# each of four pairs shares 2 of 4 scans with its other self
RENAMED = [([0], [1], [[1.0]])] * 2 + [([0], [2], [[1.0]])] * 2
# pairs from 0.05 to 0.6, 12 of 19 similarities: 2 of 4 found, 2 of 4 together
UNSEEN: Scan = ([0], [], [[]])
LATE = [UNSEEN, UNSEEN, ([0], [1], [[0.6]]), ([0], [1], [[0.6]])]
# 4 found, 4 false
FALSE = [([0], [1, 2], [[1.0, 0.0]])] * 4
# each of 8 pairs: 2 scans together of 4 and 4, 6 in all
SWAPPED = [([0, 1], [1, 2], [[1.0, 0.0], [0.0, 1.0]])] * 2 + [([0, 1], [1, 2], [[0.0, 1.0], [1.0, 0.0]])] * 2
# the nearer track is the stranger of one scan: whom the object has before and after stays its own
STRANGER = [([0], [1], [[0.8]]), ([0], [1, 2], [[0.8, 0.9]]), ([0], [1], [[0.8]])]


@pytest.mark.parametrize(
    ("scans", "expected", "expected_f1"),
    [
        (PERFECT, (1.0, 1.0, 1.0), 1.0),
        (RENAMED, (math.sqrt(0.5), 1.0, 0.5), 4 / 8),
        (LATE, (0.5 * 12 / 19, 0.5 * 12 / 19, 0.5 * 12 / 19), 4 / 6),
        (FALSE, (math.sqrt(0.5), 0.5, 1.0), 8 / 12),
        (SWAPPED, (math.sqrt(1 / 3), 1.0, 1 / 3), 8 / 16),
        (STRANGER, (16 / 19 * math.sqrt(3 / 4), 16 / 19 * 3 / 4, 16 / 19), 6 / 7),
        ([([0], [], [[]])], (0.0, 0.0, 0.0), 0.0),
        ([([], [4], [])], (0.0, 0.0, 0.0), 0.0),
    ],
)
def test_cases_worked_by_hand(
    scans: list[Scan],
    expected: tuple[float, float, float],
    expected_f1: float,
) -> None:
    frames = run(*scans)
    assert hota(frames) == pytest.approx(expected, abs=1e-12)
    assert idf1(frames) == pytest.approx(expected_f1, abs=1e-12)


def test_nothing_at_all_has_no_score() -> None:
    assert math.isnan(hota([]).hota)
    assert math.isnan(idf1([]))


def test_an_identity_is_held_within_three_metres() -> None:
    np.testing.assert_allclose(similarity(np.array([0.0, 3.0, 6.0, 9.0])), [1.0, 0.5, 0.0, 0.0])
