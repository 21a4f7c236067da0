"""How sharply an echo sets in, in widths of the point that speckle shows, against closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.ndimage import gaussian_filter1d

from ods.base.arrays import Floats, Image
from tests.pipeline.steps import measured

FULL_WIDTH = 2.0 * math.sqrt(2.0 * math.log(2.0))
"""Of a Gaussian at half its level, in standard deviations."""
FIRST, BEAM = 700, 31
"""Column and beam of the echo: in no stretch of a beam that the width is measured on."""


def speckle(sigma: float, relief: float = 0.0, seed: int = 1) -> Image:
    """Draw white noise through a Gaussian filter; relief: of half of the beams' levels, over 8 columns."""
    rng = np.random.default_rng(seed)
    white = gaussian_filter1d(rng.normal(size=(60, 1200)), sigma, axis=1)
    levels = 1.0 + 0.1 * white / white.std()
    levels[:30] *= 1.0 + relief * np.sin(2.0 * np.pi * np.arange(1200) / 8.0)
    return np.asarray(levels, np.float32)


def onset(row: Floats, image: Image) -> float:
    """Return the onset of an echo of these levels."""
    shown = image.copy()
    shown[BEAM, FIRST : FIRST + row.size] = row
    return float(measured(shown, [(BEAM, FIRST, FIRST + row.size)]).echoes["onset"][0])


def peak(sigma: float) -> Floats:
    return np.asarray(20.0 * np.exp(-0.5 * ((np.arange(80) - 40.0) / sigma) ** 2))


@pytest.mark.parametrize("of_filter", [0.85, 1.2, 1.8])
@pytest.mark.parametrize("of_echo", [1.5, 3.0, 6.0])
def test_a_gaussian_sets_in_within_half_its_width(of_echo: float, of_filter: float) -> None:
    assert onset(peak(of_echo), speckle(of_filter)) == pytest.approx(0.5 * of_echo / of_filter, rel=0.15)


def test_relief_of_a_part_of_the_bottom_does_not_widen_a_point() -> None:
    assert onset(peak(3.0), speckle(0.85, 0.3)) == pytest.approx(onset(peak(3.0), speckle(0.85)), rel=0.1)


def test_what_comes_behind_the_highest_level_says_nothing() -> None:
    rise = [1.0, 1.0, 4.0, 12.0, 20.0]
    short, long = (onset(np.array(rise + [18.0] * count), speckle(1.2)) for count in (1, 30))
    assert short == long > 0.0


@settings(max_examples=40)
@given(st.lists(st.floats(0.0, 1e6, width=32), min_size=2, max_size=60))
def test_it_is_finite_and_never_negative_whatever_the_levels(levels: list[float]) -> None:
    reported = onset(np.array([1.0, *levels, 2e6]), speckle(1.2))
    assert math.isfinite(reported)
    assert reported >= 0.0


@pytest.mark.parametrize(
    "image", [np.ones((60, 1200), np.float32), 10.0 * speckle(1.0)], ids=["without speckle", "all of it an echo"]
)
def test_without_speckle_no_onset_is_reported(image: Image) -> None:
    assert onset(peak(3.0), image) == 0.0


def test_a_few_columns_of_speckle_are_too_few() -> None:
    image = speckle(1.0)[:, :100]
    image[BEAM, 10:90] = peak(3.0)
    assert measured(image, [(BEAM, 10, 90)]).echoes["onset"] == 0.0


def test_where_data_begin_later_it_is_not_reported() -> None:
    assert onset(np.array([0.0, 20.0, 18.0]), speckle(1.2)) == 0.0
