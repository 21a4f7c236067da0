"""Levels that follow the crests of the background, held against counts of what reaches them."""

import msgspec
import numpy as np
import pytest

from ods.base.arrays import Image
from ods.compiled import native
from ods.messages import Detections, Ping
from ods.pipeline.chain import Chain
from ods.pipeline.detect.background.crests import LocalThreshold, crest_quantiles
from ods.pipeline.detect.background.rise import ThresholdRise, levelled
from ods.pipeline.detect.regions.grouping import GrowingRule, find_regions, room_for_runs
from ods.pipeline.image.regions import RUN
from ods.pipeline.settings import DEFAULT_STAGES, PipelineSettings
from tests.pipeline.pings import make_ping, speckle

SHAPE = 64, 512
TILE = 4, 16


def rayleigh(seed: int) -> Image:
    return np.random.default_rng(seed).rayleigh(1.0, SHAPE).astype(np.float32)


def learnt() -> LocalThreshold:
    meter = LocalThreshold(SHAPE)
    meter.learn(rayleigh(k) for k in range(8))
    return meter


def levelled_by(meter: LocalThreshold, image: Image, noise: tuple[float, float], follow: float) -> Image:
    return levelled(image, ThresholdRise(noise[0], meter.factors(image, noise, 5.5), follow, follow, *meter.region))


def measured(image: Image) -> tuple[float, float]:
    middle, upper = np.quantile(image, [0.5, 0.8413])
    return float(middle), float(upper - middle)


def test_quantiles_are_those_of_the_tiles_of_a_region_and_the_eight_around_it() -> None:
    image = rayleigh(3)
    background, noise = measured(image)
    found = crest_quantiles(image, TILE, background, noise, (4, 8))
    maxima = (image.reshape(16, 4, 32, 16).max(axis=(1, 3)) - background) / noise
    for i, j, rows, columns in ((0, 0, slice(0, 8), slice(0, 8)), (2, 3, slice(4, 16), slice(8, 20))):
        np.testing.assert_allclose(found[i, j], np.quantile(maxima[rows, columns], [0.5, 0.9]), atol=0.1)


def test_tiles_without_data_do_not_count() -> None:
    image = np.zeros(SHAPE, np.float32)
    image[:16, :64] = 2.0  # 16 tiles, of which 32 are needed
    assert (crest_quantiles(image, TILE, 1.0, 0.5, (4, 8)) == 0.0).all()
    image[:16, :128] = 2.0
    assert (crest_quantiles(image, TILE, 1.0, 0.5, (4, 8))[0, 0] > 2.0).all()


def test_speckle_is_left_alone_and_follow_zero_is_too() -> None:
    meter = learnt()
    changed = 0.0
    for seed in range(20, 30):
        image = rayleigh(seed)
        out = levelled_by(meter, image, measured(image), 1.0)
        changed += float((out != image).mean()) / 10
    assert changed < 0.15


def test_a_region_of_high_crests_is_brought_to_those_of_speckle() -> None:
    meter, image = learnt(), rayleigh(40)
    texture = np.sqrt(np.random.default_rng(1).gamma(1.0, 1.0, (SHAPE[0], 256))).astype(np.float32)
    image[:, 256:] *= texture
    noise = measured(image)
    out = levelled_by(meter, image, noise, 1.0).copy()
    level = noise[0] + 4.0 * noise[1]
    before, after = (image[:, 320:] > level).sum(), (out[:, 320:] > level).sum()
    assert after < before / 4
    np.testing.assert_array_equal(out[:, :128], image[:, :128])
    half = levelled_by(meter, image, noise, 0.5)
    assert after < (half[:, 320:] > level).sum() < before


def test_what_is_levelled_keeps_the_background_and_divides_what_is_over_it() -> None:
    image = rayleigh(5)
    factors = np.random.default_rng(2).uniform(1.0, 2.5, (4, 8))
    factors[1, 2] = 1.0
    out = levelled(image, ThresholdRise(1.2, factors, 0.5, 1.0, 16, 64))
    each = np.sqrt(np.repeat(np.repeat(factors, 16, 0), 64, 1))
    np.testing.assert_allclose(out, 1.2 + (image - 1.2) / each, rtol=1e-5, atol=1e-6)
    np.testing.assert_array_equal(out[16:32, 128:192], image[16:32, 128:192])


@pytest.mark.parametrize("power", [0.0, 0.3, 1.0])
def test_regions_over_levels_that_rise_are_those_of_the_levelled_image(power: float) -> None:
    image = rayleigh(6)
    factors = np.random.default_rng(3).uniform(1.0, 1.5, (4, 7))  # the last places are wider
    rise = ThresholdRise(1.2, factors, power, power, 16, 70)
    rule = GrowingRule(1.9, 2.5, 1, 2, image.size)
    visited = np.zeros(SHAPE, np.bool_)
    risen, count = find_regions(image, rule._replace(rise=rise), room_for_runs(SHAPE), visited)
    plain, of_plain = find_regions(levelled(image, rise), rule, room_for_runs(SHAPE), visited)
    assert count == of_plain > 50
    assert risen.tolist() == plain.tolist()


def test_few_tiles_change_nothing() -> None:
    meter = LocalThreshold((8, 64))
    images = [np.random.default_rng(k).rayleigh(1.0, (8, 64)).astype(np.float32) for k in range(8)]
    meter.learn(images)
    assert levelled_by(meter, images[0], measured(images[0]), 1.0) is images[0]


@pytest.mark.parametrize("follow", [0.75, 1.0])
def test_heavy_tails_give_few_echoes_and_an_object_among_them_is_found(follow: float) -> None:
    *filters, detector = DEFAULT_STAGES
    rng = np.random.default_rng(7)
    plain, following = (
        Chain(PipelineSettings(stage=(*filters, {**detector, "follow": value}))) for value in (0.0, follow)
    )
    false = np.zeros(2)
    for _ in range(6):
        intensity = rng.gamma(0.5, 2.0, (60, 2000))
        intensity[30:33, 900:930] += 100.0
        ping = make_ping((300.0 * np.sqrt(intensity * rng.standard_exponential((60, 2000)))).astype(np.uint16))
        for k, chain in enumerate((plain, following)):
            mask = np.zeros((60, 2000), np.int32)
            count = len(chain.process(ping, mask).detections)
            assert mask[31, 905:925].any()
            false[k] += count - 1
    assert false[0] > 12
    assert false[1] < false[0] / 5


def test_regions_reach_the_level_of_the_place_that_their_cells_are_in() -> None:
    image = np.zeros((8, 8), np.float32)
    image[1, 2:6], image[6, 1], image[6, 6] = (1.0, 1.0, 1.0, 3.0), 3.0, 5.0
    runs = np.array([(1, 2, 6, 1), (6, 1, 2, 2), (6, 6, 7, 3)], RUN)
    rise = ThresholdRise(
        0.0, np.array([[81.0, 4.0], [9.0, 16.0]]), 0.0, 0.5, 4, 4
    )  # of quarters; a level has to be exceeded
    found = np.empty(3, np.bool_)
    native.reaching(image, runs, 1.0, rise, found)
    assert found.tolist() == [True, False, True]


def bed_and_ball(seed: int) -> Ping:
    """Return K-distributed clutter in the far half, and a body in the near one."""
    rng = np.random.default_rng(seed)
    intensity = np.ones((60, 2000))
    intensity[:, 1000:] = rng.gamma(0.5, 2.0, (60, 1000))
    intensity[20:23, 400:430] += 100.0
    return make_ping((300.0 * np.sqrt(intensity * rng.standard_exponential((60, 2000)))).astype(np.uint16))


def test_faint_echoes_are_those_that_only_the_lower_level_shows() -> None:
    *filters, detector = DEFAULT_STAGES
    both, low, high = (
        Chain(PipelineSettings(stage=(*filters, {**detector, "follow": follow, "faint": faint, "fronts": False})))
        for follow, faint in ((1.0, 0.3), (0.3, 0.3), (1.0, 1.0))
    )
    faint = 0
    for seed in range(3):
        ping = bed_and_ball(seed)
        parted, all_found, strong = both.process(ping), low.process(ping), high.process(ping)
        assert sorted(parted.detections + parted.faint, key=repr) == sorted(all_found.detections, key=repr)
        assert not all_found.faint
        assert not strong.faint
        assert len(parted.detections) <= len(strong.detections)  # two that touch at the lower level are one
        assert any(abs(echo.near_m - 20.0) < 1.0 for echo in parted.detections)
        faint += len(parted.faint)
    assert faint > 5


def test_faint_echoes_are_not_marked() -> None:
    *filters, detector = DEFAULT_STAGES
    chain = Chain(PipelineSettings(stage=(*filters, {**detector, "follow": 1.0, "fronts": False})))
    mask = np.zeros((60, 2000), np.int32)
    found = chain.process(bed_and_ball(1), mask)
    assert found.faint
    assert set(np.unique(mask)) == {0, *range(1, len(found.detections) + 1)}


def test_echoes_are_detected_from_the_level_that_is_reported() -> None:
    chain, rng = Chain(PipelineSettings()), np.random.default_rng(5)
    intensity = np.ones((60, 2000))
    for k in range(40):  # bodies from 0 to 20 dB
        beam, column = 3 + 11 * (k % 5), 100 + 220 * (k // 5)
        intensity[beam : beam + 3, column : column + 12] += 10.0 ** (k / 20.0)
    found = chain.process(make_ping((300.0 * np.sqrt(intensity * rng.standard_exponential((60, 2000)))).astype("u2")))
    assert found.heard_from_db is not None
    peaks_db = 20.0 * np.log10([echo.peak for echo in found.detections + found.faint])
    assert len(peaks_db) > 15
    assert found.heard_from_db < min(peaks_db) < found.heard_from_db + 1.0


def test_crests_of_the_background_raise_the_level_from_which_echoes_are_detected() -> None:
    rng = np.random.default_rng(6)
    smooth, rough = np.ones((60, 2000)), rng.gamma(0.5, 2.0, (60, 2000))
    levels: list[float] = []
    for intensity in (smooth, rough, 100.0 * rough):
        frame = 30.0 * np.sqrt(intensity * rng.standard_exponential((60, 2000)))
        reported = Chain(PipelineSettings()).process(make_ping(frame.astype(np.float32))).heard_from_db
        assert reported is not None
        levels.append(reported)
    assert levels[0] == pytest.approx(7.0, abs=1.0)
    assert levels[0] + 3.0 < levels[1]
    assert levels[2] == pytest.approx(levels[1], abs=0.5)  # it is a ratio


def test_an_image_of_nothing_tells_no_level() -> None:
    nothing = make_ping(np.zeros((60, 2000), np.uint16))
    assert Chain(PipelineSettings()).process(nothing).heard_from_db is None


@pytest.mark.parametrize(("high", "told_db"), [(0.001, 0.0), (1e20, 200.0)])
def test_levels_far_from_the_background_make_no_message_that_nobody_can_read(high: float, told_db: float) -> None:
    stages = ({"use": "filter.box"}, {"use": "detect.two_level", "levels": "absolute", "high": high, "low": high})
    frame = speckle(np.random.default_rng(8), np.ones((60, 2000))).astype(np.float32)
    reported = Chain(PipelineSettings(stage=stages)).process(make_ping(frame))
    assert reported.heard_from_db == told_db
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(reported), type=Detections) == reported
