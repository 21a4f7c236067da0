import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import ndimage

from ods.base.arrays import AnyArray, Image, Ints32
from ods.compiled import native
from ods.pipeline.detect.background.noise import background_and_noise
from ods.pipeline.detect.levels import two_level
from ods.pipeline.detect.regions.grouping import GrowingRule, find_regions, room_for_runs
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.missing.no_data import ALL_DATA
from ods.pipeline.image.regions import Regions
from ods.pipeline.image.samples.recorded import Recorded, mark_region
from ods.pipeline.stage.params import NotANumberError, TwoLevelParams


def as_recorded(image: Image) -> Recorded:
    return Recorded(image, np.arange(image.shape[1]), 1)


def mask_of(regions: Regions, image: Image) -> Ints32:
    mask = np.zeros(image.shape, np.int32)
    mark_region(regions, 0, as_recorded(image), mask)
    return mask


def detect(image: Image, params: TwoLevelParams | None = None) -> Regions:
    beams, samples = image.shape
    fan = Fan(np.linspace(-0.5, 0.5, beams + 1)[1:], np.full(beams, 0.02), samples, 0.0, 0.05)
    return two_level(params or TwoLevelParams(), fan).find(image, as_recorded(image))


def speckle(seed: int = 0, shape: tuple[int, int] = (60, 1000)) -> Image:
    amplitude = np.random.default_rng(seed).rayleigh(1.0, shape)
    return ndimage.uniform_filter1d(amplitude, 9, axis=1).astype(np.float32)


@settings(max_examples=100, deadline=None)
@given(
    beams=st.integers(1, 18),
    samples=st.integers(1, 150),
    low=st.floats(0.2, 0.95),
    smallest=st.integers(1, 12),
    largest=st.sampled_from([15, 10**6]),
    connectivity=st.sampled_from([4, 8]),
    seed=st.integers(0, 10**6),
)
def test_regions_agree_with_labelling_by_scipy(
    beams: int, samples: int, low: float, smallest: int, largest: int, connectivity: int, seed: int
) -> None:
    image = np.random.default_rng(seed).random((beams, samples)).astype(np.float32)
    level, high = np.float32(low), np.float32(0.97)
    work, visited = room_for_runs(image.shape), np.zeros(image.shape, np.bool_)
    rule = GrowingRule(float(level), float(high), int(connectivity == 8), smallest, largest)
    runs, count = find_regions(image, rule, work, visited)
    assert not visited.any()
    labels, number = ndimage.label(image > level, ndimage.generate_binary_structure(2, 1 + (connectivity == 8)))
    sizes = np.bincount(labels.ravel(), minlength=number + 1)
    strong = np.unique(labels[image > high])
    kept = [k for k in strong if k and smallest <= sizes[k] <= largest]
    mask = mask_of(Regions(runs, count, 1.0), image)
    assert count == len(kept)
    np.testing.assert_array_equal(mask > 0, np.isin(labels, kept))
    pairs = set(zip(mask[mask > 0].tolist(), labels[mask > 0].tolist(), strict=True))
    assert len(pairs) == count
    order = np.lexsort((runs["first"], runs["beam"], runs["region"]))
    np.testing.assert_array_equal(order, np.arange(len(runs)))


def test_low_level_says_how_far_and_high_level_that_it_exists() -> None:
    image = np.ones((9, 200), np.float32)
    image[3:6, 50:70] = 3.0
    image[4, 60] = 9.0
    image[3:6, 120:140] = 3.0
    image[6, 70] = 3.0  # touches the first one by a corner
    regions = detect(image, TwoLevelParams(levels="background", low=2.0, high=6.0))
    assert regions.total == 1
    assert regions.background == pytest.approx(1.0, rel=0.02)
    assert (mask_of(regions, image) > 0).sum() == 61


def test_background_and_noise_are_the_quantiles() -> None:
    image = speckle()
    quantile = np.quantile(image, [0.5, 0.8413])
    middle, noise = background_and_noise(image)
    assert middle == pytest.approx(quantile[0], rel=0.02)
    assert noise == pytest.approx(quantile[1] - quantile[0], rel=0.08)
    image[10:30, 100:130] = 50.0  # 1 % of the image
    assert background_and_noise(image)[1] == pytest.approx(1.04 * noise, rel=0.08)


def test_levels_adapt_to_the_scale_of_the_image() -> None:
    image = speckle()
    image[20:24, 500:540] += 3.0
    found = detect(image)
    assert found.total == 1
    np.testing.assert_array_equal(detect(image * np.float32(1e6)).runs, found.runs)


def test_images_of_nothing_give_nothing() -> None:
    for image in (np.zeros((5, 80)), np.full((5, 80), 3.0), np.full((1, 1), 2.0)):
        regions = detect(image.astype(np.float32))
        assert regions.total == 0
        assert regions.background > 0.0


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_images_with_cells_that_are_no_numbers_are_refused(value: float) -> None:
    image = speckle()
    image[5, 5] = value
    for ill in (image, np.full_like(image, value)):
        with pytest.raises(NotANumberError):
            detect(ill)
    assert detect(speckle()).total == 0


def test_low_above_high_is_refused() -> None:
    with pytest.raises(ValueError, match="low"):
        TwoLevelParams(low=7.0, high=6.0)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("share", [0.0, 0.003, 0.12, 1.0])
def test_level_of_the_strongest_is_a_sample_that_so_many_reach(dtype: type, share: float) -> None:
    rng = np.random.default_rng(2)
    samples: AnyArray = (
        (100.0 * rng.normal(size=(30, 130)) + (0 if dtype == np.float32 else 300)).clip(-250, 255).astype(dtype)
    )
    lost = rng.random(samples.shape) < 0.3
    for missing in (ALL_DATA, lost):
        held = np.sort(samples[~missing] if missing.size else samples.ravel())
        recorded = Recorded(samples, np.arange(130), 1, missing)
        assert native.level_of_strongest(recorded, share) == held[min(int((1.0 - share) * held.size), held.size - 1)]
    assert native.level_of_strongest(Recorded(samples, np.arange(130), 1, np.ones_like(lost)), share) == 0.0


def test_counts_of_few_bits_stand_for_all_levels_halfway_to_the_next_ones() -> None:
    image = np.repeat(np.array([10.5, 20.5, 40.5], np.float32), [64, 128, 32])[None]
    counted = np.zeros((2, 100))
    assert native.count_cells(image, (0, 1), 30.0, 1.0, counted) == 160  # two blocks are near the loud one
    assert counted.sum() == pytest.approx(224.0)
    assert counted[0, 10:15] == pytest.approx(np.full(5, 64.0 / 5.5))
    assert counted[0, 15] == pytest.approx(0.5 * (64.0 / 5.5 + 96.0 / 15.0))
    assert counted[0, 16:30] == pytest.approx(np.full(14, 96.0 / 15.0))
    assert counted[1, 31:41] == pytest.approx(np.full(10, 32.0 / 10.5))
