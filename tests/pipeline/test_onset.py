"""How sharply an echo sets in, and the width of a point that it is told in, against closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.ndimage import gaussian_filter1d

from ods.base.arrays import Floats32, Image
from ods.pipeline.image.regions import RUN
from ods.pipeline.measure.onset import onset_of
from ods.pipeline.measure.response import response_width

FULL_WIDTH = 2.0 * math.sqrt(2.0 * math.log(2.0))
"""Of a Gaussian at half its level, in standard deviations."""


def told(row: Floats32, point: float = 1.0) -> float:
    image = np.zeros((3, row.size), np.float32)
    image[1] = row
    runs = np.zeros(1, RUN)
    runs[0] = 1, 0, row.size, 1
    return onset_of(image, runs, point)


@pytest.mark.parametrize("sigma", [1.5, 3.0, 6.0])
def test_a_gaussian_sets_in_within_half_its_width(sigma: float) -> None:
    row = np.exp(-0.5 * ((np.arange(80) - 40.0) / sigma) ** 2).astype(np.float32)
    assert told(row) == pytest.approx(0.5 * FULL_WIDTH * sigma, abs=0.05)
    assert told(row, FULL_WIDTH * sigma) == pytest.approx(0.5, abs=0.02)


def test_what_comes_behind_the_highest_level_says_nothing() -> None:
    rise = np.array([0.0, 0.0, 0.2, 0.6, 1.0], np.float32)
    long, short = (np.concatenate([rise, np.full(n, 0.9, np.float32), [0.0]]) for n in (1, 30))
    assert told(long.astype(np.float32)) == told(short.astype(np.float32)) == pytest.approx(1.25)


@given(st.lists(st.floats(0.0, 1e6, width=32), min_size=2, max_size=60), st.just(0.0) | st.floats(1.0, 5.0))
def test_it_is_finite_and_never_negative_whatever_the_levels(levels: list[float], point: float) -> None:
    onset = told(np.array(levels, np.float32), point)
    assert math.isfinite(onset)
    assert onset >= 0.0


@pytest.mark.parametrize(
    "row", [[1.0, 0.2], [1.0, 1.0, 0.1], [0.0, 0.0]], ids=["at the first column", "lit from the first column", "dark"]
)
def test_where_it_is_not_known_it_is_not_told(row: list[float]) -> None:
    assert told(np.array(row, np.float32)) == 0.0
    assert told(np.array([0.0, 0.1, 1.0], np.float32), 0.0) == 0.0


def speckle(sigma: float, relief: float = 0.0, seed: int = 1) -> Image:
    """Draw white noise through a Gaussian filter; relief: of half of the beams' levels, over 8 columns."""
    rng = np.random.default_rng(seed)
    white = gaussian_filter1d(rng.normal(size=(60, 1200)), sigma, axis=1)
    levels = 1.0 + 0.1 * white / white.std()
    levels[:30] *= 1.0 + relief * np.sin(2.0 * np.pi * np.arange(1200) / 8.0)
    return np.asarray(levels, np.float32)


@pytest.mark.parametrize("sigma", [0.85, 1.2, 1.8])
def test_speckle_tells_the_width_of_the_filter(sigma: float) -> None:
    assert response_width(speckle(sigma), 1.0) == pytest.approx(FULL_WIDTH * sigma, rel=0.12)


def test_relief_of_a_part_of_the_bottom_does_not_widen_it() -> None:
    assert response_width(speckle(0.85, 0.3), 1.0) == pytest.approx(response_width(speckle(0.85), 1.0), rel=0.1)


def test_without_speckle_no_width_is_told() -> None:
    assert response_width(np.ones((60, 1200), np.float32), 1.0) == 0.0
    assert response_width(np.zeros((60, 1200), np.float32), 1.0) == 0.0
    assert response_width(np.ascontiguousarray(speckle(1.0)[:, :100]), 1.0) == 0.0
    assert response_width(10.0 * speckle(1.0), 1.0) == 0.0  # all of it an echo
