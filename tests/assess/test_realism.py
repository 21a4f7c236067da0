"""`python -m benchmarks.simulator.realism`: distances of images whose figures are known."""

from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from benchmarks.simulator import realism
from benchmarks.simulator.realism import MEASURES, distance, figures_of
from ods.base.arrays import Image
from ods.sonar_link.files.opening import open_pings

DATA = Path(__file__).parents[1] / "data"
RNG = np.random.default_rng(4)


def speckle(across: float = 0.0, along: float = 0.0) -> Image:
    """Return speckle of one look, (96, 480), smoothed over so many beams and samples."""
    parts = RNG.normal(size=(2, 96, 480))
    for sigma, axis in ((across, 1), (along, 2)):
        if sigma > 0.0:
            parts = gaussian_filter1d(parts, sigma, axis=axis)
    return np.asarray(np.hypot(*parts), np.float32)


def test_the_same_images_have_no_distance_and_louder_ones_one_of_so_many_decibels() -> None:
    measure, values = MEASURES["level over the image's median"], RNG.normal(0.0, 5.0, 50_000)
    assert distance(values, values, measure) == pytest.approx((0.0, 0.0), abs=1e-12)
    found = distance(values, values + 3.0, measure)
    assert found.moved == pytest.approx(3.0)
    assert found.divergence == pytest.approx(0.5 * (3.0 / 5.0) ** 2, rel=0.1)  # of two normal laws


def test_the_gain_of_a_sonar_is_no_difference() -> None:
    images = [speckle(), speckle()]
    figures, louder = figures_of(images), figures_of([50.0 * image for image in images])
    for name, values in figures.items():
        np.testing.assert_allclose(louder[name], values, atol=1e-5)


def test_speckle_of_one_look_has_no_texture_but_its_law() -> None:
    figures = figures_of([speckle(), speckle()])
    for name in MEASURES:
        if name.startswith("correlation"):
            assert abs(float(np.mean(figures[name]))) < 0.02
    assert np.mean(figures["variation within a block"]) == pytest.approx(np.sqrt(4.0 / np.pi - 1.0), abs=0.01)


def test_texture_along_beams_and_samples_is_distinguished() -> None:
    along, across = figures_of([speckle(along=1.5)]), figures_of([speckle(across=1.5)])
    assert np.median(along["correlation, next sample"]) > 0.55 > 0.1 > np.median(along["correlation, next beam"])
    assert np.median(across["correlation, next beam"]) > 0.55 > 0.1 > np.median(across["correlation, next sample"])
    still = speckle()
    assert np.median(figures_of([still, still])["correlation, next ping"]) == pytest.approx(1.0)


def test_the_same_sonar_is_simulated_and_what_differs_most_is_named() -> None:
    ping = open_pings(DATA / "aris" / "sample.aris").pings[0]
    (image,) = realism.look_alike(ping, 1)
    real = realism.amplitudes(ping)
    assert image.shape == real.shape == (48, 2000)
    row, said = realism.rows("aris", figures_of([real]), {"speckle": figures_of([speckle()])})
    assert row.startswith("| aris | speckle | ")
    assert said.startswith("aris against speckle: most ")
