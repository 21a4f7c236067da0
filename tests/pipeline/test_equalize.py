import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ods.base.arrays import Image
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.params import MeanRangeParams
from tests.pipeline.steps import stage_on_images


def fan(shape: tuple[int, ...]) -> Fan:
    beams, samples = shape
    return Fan(np.linspace(-0.5, 0.5, beams + 1)[1:], np.full(beams, 0.02), samples, 0.0, 0.05)


def per_range(image: Image, side_lobe_db: float = 30.0) -> Image:
    return stage_on_images("equalize.mean_range", fan(image.shape), MeanRangeParams(side_lobe_db=side_lobe_db))(image)


def per_place(image: Image) -> Image:
    return stage_on_images("equalize.local", fan(image.shape))(image)


def speckle(beams: int, samples: int, seed: int = 0) -> Image:
    return np.random.default_rng(seed).rayleigh(1.0, (beams, samples)).astype(np.float32)


def test_bias_of_the_bottom_belts_and_drop_outs_are_levelled() -> None:
    column = np.arange(2000)
    gain = np.where(column < 360, 1.0, 6.0)
    gain[1000:1200] *= 0.4
    gain[1400:1600] *= 2.5
    gain[1500:1506] *= 0.02
    out = per_range(speckle(60, 2000) * gain.astype(np.float32))
    means = out.mean(axis=0)
    assert np.mean(np.abs(means - 1.0) < 1e-3) > 0.97
    assert means.min() > 0.99
    assert means.max() < 2.0  # only at the steps themselves


def test_wall_across_the_whole_sector_does_not_erase_itself() -> None:
    image = speckle(60, 2000)
    image[:, 900:920] *= 8.0
    assert per_range(image)[:, 900:920].mean() > 5.0


def test_side_lobes_of_a_strong_echo_are_levelled_beside_it() -> None:
    image = speckle(60, 2000)
    image[:, 700:740] *= 3.0  # side lobes, 30 dB under the echo
    image[30, 700:740] = 100.0
    out = per_range(image, side_lobe_db=30.0)
    assert out[:25, 700:740].mean() < 1.3
    assert out[30, 700:740].min() > 20.0


def test_empty_ranges_stay_empty_and_flat_images_become_one() -> None:
    image = speckle(8, 300)
    image[:, 100:110] = 0.0
    out = per_place(per_range(image))
    assert np.isfinite(out).all()
    assert not out[:, 100:110].any()
    np.testing.assert_allclose(per_range(np.full((5, 70), 7.0, np.float32)), 1.0, rtol=1e-6)
    assert not per_place(per_range(np.zeros((5, 70), np.float32))).any()


def test_nan_stays_where_it_is() -> None:
    image = speckle(20, 400)
    image[3, 200] = np.nan
    out = per_range(image)
    assert np.isfinite(np.delete(out, slice(192, 224), axis=1)).all()


def test_gain_of_beams_is_levelled_by_place() -> None:
    gain = np.linspace(0.6, 1.6, 48, dtype=np.float32)[:, None]
    out = per_place(speckle(48, 2000) * gain)
    np.testing.assert_allclose(out.reshape(8, 6, 2000).mean(axis=(1, 2)), 1.0, atol=0.05)


def test_lit_bottom_beside_a_shadow_is_not_raised() -> None:
    """Whatever the shadow's edges are in the blocks; a block of half the level beside it would raise it by 1.5."""
    for first, last in ((9, 43), (12, 50), (20, 41)):
        image = speckle(60, 2000)
        image[first:last, 1200:] *= 0.3
        out = per_place(per_range(image))
        for lit in (out[first - 3 : first, 1300:], out[last : last + 3, 1300:]):
            assert lit.mean() < 1.35
        assert out[:, :1100].mean() == pytest.approx(1.0, abs=0.05)


def test_where_there_is_no_data_what_is_beside_it_is_levelled() -> None:
    image = 1e-3 * speckle(60, 2000)
    image[30:45] = 0.0
    out = per_place(image)
    assert out[:30].mean() == pytest.approx(1.0, abs=0.05)
    assert out[45:].mean() == pytest.approx(1.0, abs=0.05)


def test_wide_object_does_not_erase_itself_by_place() -> None:
    image = speckle(60, 2000)
    image[10:40, 1000:1080] *= 6.0
    out = per_place(image)
    assert out[10:40, 1000:1080].mean() > 4.5
    assert out.mean(axis=1).max() / out.mean(axis=1).min() < 1.25


@settings(max_examples=30, deadline=None)
@given(
    beams=st.integers(1, 9),
    samples=st.integers(1, 80),
    seed=st.integers(0, 99),
    zeros=st.booleans(),
    scale=st.sampled_from([1e-12, 1.0, 1e14]),
)
def test_any_shape_and_scale_gives_finite_images(
    beams: int, samples: int, seed: int, zeros: bool, scale: float
) -> None:
    image = speckle(beams, samples, seed) * np.float32(scale)
    if zeros:
        image[:, ::2] = 0.0
    out = per_place(per_range(image))
    assert np.isfinite(out).all()
    assert out.min() >= 0.0
    assert out.max() > 0.0 or samples == 1


def test_scale_does_not_matter() -> None:
    image = speckle(20, 500)
    once = per_place(per_range(image))
    np.testing.assert_allclose(per_place(per_range(image * np.float32(1e4))), once, rtol=1e-4)
    assert once.mean() == pytest.approx(1.0, abs=0.05)
