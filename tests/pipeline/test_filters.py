from typing import Literal

import numpy as np
import pytest
from scipy import ndimage, signal

from ods.base.arrays import Image
from ods.base.settings import Settings
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.params import BoxParams, FirParams, MedianParams, WienerParams
from tests.pipeline.steps import stage_on_images


def apply(use: str, params: Settings, image: Image) -> Image:
    beams, samples = image.shape
    fan = Fan(np.linspace(-0.5, 0.5, beams + 1)[1:], np.full(beams, 0.02), samples, 0.0, 0.05)
    return stage_on_images(use, fan, params)(image)


def image_of(beams: int, samples: int) -> Image:
    return np.random.default_rng(samples).rayleigh(1.0, (beams, samples)).astype(np.float32)


SHAPES = [(3, 200), (2, 9), (2, 5), (4, 2), (3, 1)]
"""Down to rows that are shorter than the windows: mirrored again and again."""


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("taps", "cutoff"), [(1, 0.5), (3, 0.3), (9, 0.1), (11, 0.25), (31, 0.05)])
def test_fir_agrees_with_scipy(shape: tuple[int, int], taps: int, cutoff: float) -> None:
    image = image_of(*shape)
    expected = ndimage.correlate1d(image, signal.firwin(taps, cutoff), axis=1, mode="mirror")
    np.testing.assert_allclose(apply("filter.fir", FirParams(taps=taps, cutoff=cutoff), image), expected, atol=2e-6)


@pytest.mark.parametrize(("taps", "cutoff"), [(9, 0.9), (999, 0.2)])
def test_a_filter_that_overshoots_does_not_smooth_across_the_beams(taps: int, cutoff: float) -> None:
    image = image_of(9, 2000)
    alone, round_too = (
        apply("filter.fir", FirParams(taps=taps, cutoff=cutoff, round_beams=beams), image) for beams in (0.0, 3.0)
    )
    np.testing.assert_array_equal(round_too, alone)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("window", [1, 3, 9, 15])
def test_box_agrees_with_scipy(shape: tuple[int, int], window: int) -> None:
    image = image_of(*shape)
    expected = ndimage.uniform_filter1d(image.astype(np.float64), window, axis=1, mode="mirror")
    np.testing.assert_allclose(apply("filter.box", BoxParams(window=window), image), expected, atol=2e-6)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("window", [3, 5, 7, 9])
def test_median_agrees_with_scipy(shape: tuple[int, int], window: Literal[3, 5, 7, 9]) -> None:
    image = np.round(image_of(*shape), 1)  # with ties
    expected = ndimage.median_filter(image, (1, window), mode="mirror")
    np.testing.assert_array_equal(apply("filter.median", MedianParams(window=window), image), expected)


@pytest.mark.parametrize("window", [3, 9, 15])
def test_wiener_agrees_with_scipy_away_from_the_ends(window: int) -> None:
    image = image_of(5, 3000)
    image[:, 1000:1040] *= 6.0
    ours = apply("filter.wiener", WienerParams(window=window), image)
    # scipy sees zeros beyond the ends, so its noise is given: the mean of the variances of a mirrored image
    wide = np.pad(image.astype(np.float64), ((0, 0), (window, window)), mode="reflect")
    mean = ndimage.uniform_filter1d(wide, window, axis=1)
    variance = ndimage.uniform_filter1d(wide**2, window, axis=1) - mean**2
    noise = float(variance[:, window:-window].mean())
    expected = signal.wiener(wide, (1, window), noise)[:, window:-window]
    np.testing.assert_allclose(ours, expected, atol=2e-4)


def test_flat_images_pass_all_filters() -> None:
    flat = np.full((3, 40), 5.0, np.float32)
    params = {"fir": FirParams(), "box": BoxParams(), "wiener": WienerParams(), "median": MedianParams()}
    for name, values in params.items():
        np.testing.assert_allclose(apply(f"filter.{name}", values, flat), 5.0, rtol=1e-6)
