"""How well circles are known: the law that is fitted, what it is fed with, and the command that fits it."""

from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from benchmarks.circles import bed_spheres, laws as circle_laws, synthetic as circles
from benchmarks.circles.fitted_layers import Layers, beginning, fitted, variance_loss
from ods.assess.sea.assessment import shipped_folder
from ods.assess.sea.run import head_at, images_of, scene_with_seed
from ods.base.arrays import Image
from ods.pipeline.chain import Chain
from ods.pipeline.measure.echoes import SIGMA_NETWORK
from ods.pipeline.measure.sigmas.features import Features
from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.by_name import find_sonar
from tests.pipeline.steps import DR_M, measured

INPUTS = len(Features._fields)


@pytest.mark.parametrize("kind", ["front", "disc", "plate"])
def test_errors_are_as_large_as_is_claimed(kind: str) -> None:
    """Of bodies of one kind, which is not reported: of draws that are none of those that the laws are fitted to.

    Near edge, range, radius, place across; plates are better placed in range than what looks like them.
    """
    rng, chain = np.random.default_rng([2026, 11, 23, 6, len(kind)]), Chain(PipelineSettings())
    cases = (circles.drawn(kind, rng.uniform(8.0, 25.0), rng) for _ in range(120))
    errors = circles.errors_of([look for case in cases for look in circles.looks(chain, case, 1, rng)])
    assert len(errors.wrong) > 60
    square = np.minimum(errors.normalized() ** 2, circles.GATE_SIGMAS**2).mean(0)
    assert (square > (0.5, 0.4, 0.5, 0.5)).all(), square
    assert (square < 2.0).all(), square


def test_errors_over_a_sea_bed_are_as_large_as_is_claimed() -> None:
    """Spheres over rocks, by the simulator: a bed and bodies that no law is fitted to. Place across, and range.

    Rocks are the bed over which the range is worst: 2.2 here, 3.4 before the law was fitted over beds, too.
    """
    scene, chain = scene_with_seed(shipped_folder() / "rocky.toml", 40), Chain(PipelineSettings())
    across: list[float] = []
    along: list[float] = []
    for ping, truth in images_of(scene, find_sonar("seabat6012"), 35.0):
        head = head_at(scene, ping.t_ns)
        for look in bed_spheres.looks_at(truth, head, chain.process(ping, pose=head)):
            assert look.found
            across.append((look.found.bearing_rad - look.bearing) / look.found.sigma_bearing_rad)
            along.append((look.found.range_m - look.case.range_m) / look.found.sigma_range_m)
    assert len(across) > 200
    for normalized, most in ((across, 2.0), (along, 3.0)):
        assert 0.5 < np.minimum(np.square(normalized), circles.GATE_SIGMAS**2).mean() < most


def echo_of(seed: int) -> tuple[Image, list[tuple[int, int, int]]]:
    """Draw an image of filtered speckle, and an echo in it of beams that lie side by side, of any levels and extent."""
    rng = np.random.default_rng(seed)
    image = np.abs(gaussian_filter1d(rng.normal(size=(40, 300)), rng.uniform(0.5, 3.0), axis=1)).astype(np.float32)
    image /= np.median(image)
    beam, column = int(rng.integers(3, 20)), int(rng.integers(20, 120))
    runs = []
    for k in range(int(rng.integers(1, 15))):
        first = column + int(rng.integers(0, 8))
        runs.append((beam + k, first, first + 9 + int(10.0 ** rng.uniform(0.0, 2.0))))
        row = image[beam + k, first : runs[-1][2]]
        row += 10.0 ** rng.uniform(0.0, 6.0) * rng.exponential(size=row.size).astype(np.float32)
    return image, runs


def test_every_echo_has_finite_sigmas_and_none_below_the_columns() -> None:
    for seed in range(200):
        reported = measured(*echo_of(seed))
        assert np.isfinite(reported.features).all()
        echo = reported.echoes[0]
        across = echo["sigma_bearing_rad"] * echo["range_m"]
        claimed = [echo["sigma_near_m"], echo["sigma_range_m"], echo["sigma_radius_m"], across]
        assert np.isfinite(claimed).all()
        assert min(claimed) > 0.28 * DR_M  # 1/sqrt(12): what is rounded to whole columns


def test_a_law_is_two_layers() -> None:
    """That of the radius, all but the contrast, and that of the range."""
    with np.load(SIGMA_NETWORK) as laws:
        sigmas, along = (Layers(laws[f"{name}_hidden"], laws[f"{name}_out"]) for name in ("sigmas", "range"))
    for seed in range(60):
        reported = measured(*echo_of(seed))
        echo = reported.echoes[0]
        near, radius, _ = reported.point * DR_M * np.exp(0.5 * sigmas.outputs(reported.features[:, :-1])[0])
        (deep,) = reported.point * DR_M * np.exp(0.5 * along.outputs(reported.features)[0])
        least = DR_M / np.sqrt(12.0)
        assert echo["sigma_radius_m"] == pytest.approx(max(radius, least), rel=1e-3)
        assert echo["sigma_range_m"] == pytest.approx(max(deep, least, echo["sigma_near_m"]), rel=1e-3)
        assert echo["sigma_near_m"] >= max(near, least) * (1.0 - 1e-3)


@pytest.mark.parametrize("sigma", [1.0, 1.5, 2.5])
def test_width_of_a_point_is_that_of_the_filter(sigma: float) -> None:
    """White speckle through a Gaussian of standard deviation s: a point is sqrt(8 ln 2) s wide at half its level.

    Cells that may be an echo's are left out, which takes a fifth of the narrowest.
    """
    rng = np.random.default_rng(2)
    offset = np.arange(-12, 13)
    weights = np.exp(-0.5 * (offset / sigma) ** 2)
    rows = [np.convolve(row, weights / weights.sum(), "valid") for row in rng.exponential(size=(64, 1500))]
    width = measured(np.array(rows, np.float32), []).point
    assert width == pytest.approx(np.sqrt(8.0 * np.log(2.0)) * sigma, rel=0.22)


@pytest.mark.parametrize("level", [0.0, 1.0, 100.0])
def test_an_image_without_speckle_has_points_of_one_column(level: float) -> None:
    assert measured(np.full((16, 300), level, np.float32), []).point == 1.0


def test_fitted_variances_are_those_that_errors_were_drawn_with() -> None:
    rng = np.random.default_rng(3)
    inputs = rng.uniform(-1.0, 1.0, (2000, 2))
    truth = np.stack((2.0 * inputs[:, 0], np.abs(inputs[:, 1]) - 1.0), 1)
    errors = rng.normal(size=truth.shape) * np.exp(0.5 * truth)
    law = fitted(inputs, errors, beginning(inputs, 2, rng), 1e-4, 60)
    assert np.sqrt(((law.outputs(inputs) - truth) ** 2).mean()) < 0.15


def test_slope_of_the_loss() -> None:
    rng = np.random.default_rng(4)
    errors, outputs = rng.normal(size=(50, 4)) * 3.0, rng.normal(size=(50, 4))
    step = 1e-6
    rise = variance_loss(errors, outputs + step)[0] - variance_loss(errors, outputs - step)[0]
    np.testing.assert_allclose(variance_loss(errors, outputs)[1], 0.5 * rise / step, atol=1e-5)


def test_the_command_draws_the_same_bodies_and_writes_what_can_be_read(tmp_path: Path) -> None:
    seen = [list(circle_laws.seen_of(np.random.default_rng(5), 12)) for _ in range(2)]
    assert len(seen[0]) > 3
    assert [s.features for s in seen[0]] == [s.features for s in seen[1]]
    assert [circle_laws.errors(s) for s in seen[0]] == [circle_laws.errors(s) for s in seen[1]]
    rng = np.random.default_rng(6)
    sigmas = Layers(rng.normal(size=(INPUTS, 24)), rng.normal(size=(25, 3)))
    along = Layers(rng.normal(size=(INPUTS + 1, 24)), rng.normal(size=(25, 1)))
    circle_laws.save(circle_laws.Laws(sigmas, along), tmp_path / "laws.npz")
    with np.load(tmp_path / "laws.npz") as written, np.load(SIGMA_NETWORK) as shipped:
        assert {name: array.shape for name, array in written.items()} == {
            name: array.shape for name, array in shipped.items()
        }
        np.testing.assert_array_equal(written["sigmas_hidden"], sigmas.hidden)
        np.testing.assert_array_equal(written["range_out"], along.out)
