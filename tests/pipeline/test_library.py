"""The stages beside the default chain, each against a closed form or an independent way to the same figures."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage, signal

from ods.base.arrays import Bytes, Image
from ods.base.frames.geometry import quat_from_euler
from ods.messages import Pose
from ods.pipeline.chain import Chain
from ods.pipeline.image.fan import Fan
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.configured import find_stage
from ods.pipeline.stage.step import PingContext
from tests.pipeline.pings import body_echo, fan_bearings, make_ping, speckle
from tests.pipeline.steps import stage_on_images


def fan_of(image: Image, range0_m: float = 10.0) -> Fan:
    beams, samples = image.shape
    return Fan(fan_bearings(beams), np.full(beams, np.pi / 2.0 / beams), samples, range0_m, 0.05)


def apply(use: str, image: Image, **values: Any) -> Image:
    return stage_on_images(use, fan_of(image), find_stage(use).params(**values))(image)


def noise(beams: int = 60, samples: int = 900, seed: int = 0) -> Image:
    return np.random.default_rng(seed).rayleigh(1.0, (beams, samples)).astype(np.float32)


@pytest.mark.parametrize("shape", [(9, 200), (2, 30), (1, 9)])
def test_filters_across_the_beams_agree_with_scipy(shape: tuple[int, int]) -> None:
    image = noise(*shape)
    fir = ndimage.correlate1d(image, signal.firwin(9, 0.1), 1, mode="mirror")
    fir = ndimage.correlate1d(fir, signal.firwin(3, 0.4), 0, mode="mirror")
    np.testing.assert_allclose(apply("filter.fir", image, beams=3), fir, atol=2e-6)
    box = ndimage.uniform_filter(image, (5, 9), mode="mirror")
    np.testing.assert_allclose(apply("filter.box", image, beams=5), box, atol=3e-6)
    for beams in (3, 5):
        middle = ndimage.median_filter(ndimage.median_filter(image, (1, 9), mode="mirror"), (beams, 1), mode="mirror")
        np.testing.assert_array_equal(apply("filter.median", image, beams=beams), middle)
    wide = ndimage.gaussian_filter(image, (0.7, 2.5), mode="mirror", radius=(3, 8))
    np.testing.assert_allclose(apply("filter.gaussian", image, sigma=2.5, beam_sigma=0.7), wide, atol=3e-6)


def test_wiener_across_the_beams_agrees_with_its_definition() -> None:
    image = noise(12, 300)
    image[4:8, 100:140] *= 5.0
    exact = image.astype(np.float64)
    mean = ndimage.uniform_filter(exact, (3, 9), mode="mirror")
    variance = ndimage.uniform_filter(exact**2, (3, 9), mode="mirror") - mean**2
    share = np.maximum(variance - variance.mean(), 0.0) / np.maximum(variance, variance.mean())
    np.testing.assert_allclose(apply("filter.wiener", image, beams=3), mean + share * (exact - mean), atol=2e-4)


def test_fir_by_object_size_passes_objects_and_stops_speckle() -> None:
    image = np.zeros((1, 400), np.float32)
    image[0, 100:120] = 1.0  # 1 m
    image[0, 300:302] = 1.0  # 0.1 m
    out = apply("filter.fir", image, object_m=0.5)
    assert out[0, 110] > 0.9
    assert out[0, 290:312].max() < 0.25


def test_iir_is_exponential_both_ways_and_keeps_means() -> None:
    image = np.zeros((1, 301), np.float32)
    image[0, 150] = 1.0
    out = apply("filter.iir", image, length=4.0)[0]
    np.testing.assert_allclose(out[140:161], out[150] * np.exp(-np.abs(np.arange(-10, 11)) / 4.0), rtol=1e-4)
    assert out.sum() == pytest.approx(1.0, rel=1e-4)
    np.testing.assert_allclose(apply("filter.iir", np.full((2, 50), 3.0, np.float32), length=9.0), 3.0, rtol=1e-5)


def test_min_object_takes_out_what_is_smaller_and_nothing_else() -> None:
    image = np.ones((60, 900), np.float32)
    image[20:40, 100:130] = 5.0  # 1.5 m long, 8 m across
    image[20:40, 300:310] = 5.0  # 0.5 m long
    image[50, 600:660] = 5.0  # 3 m long, one beam: 1 m across at 40 m
    out = apply("filter.min_object", image, size_m=1.0)
    np.testing.assert_array_equal(out[20:40, 100:130], 5.0)
    assert out[:, 250:400].max() == 1.0
    assert out[50, 605:655].min() == 5.0
    assert apply("filter.min_object", image, size_m=4.0)[:, 550:].max() == 1.0


def test_median_per_range_does_not_see_an_object_in_less_than_half_of_the_sector() -> None:
    image = noise(60, 1000)
    image[:, 500:520] *= 0.3
    image[:10, 700:720] *= 8.0
    out = apply("equalize.median_range", image)
    assert out[:, 500:520].mean() == pytest.approx(1.0, abs=0.05)
    assert out[10:, 700:720].mean() == pytest.approx(0.9, abs=0.1)
    assert out[:10, 700:720].mean() > 6.0
    np.testing.assert_allclose(np.median(out[:, 600:650], axis=0).mean(), 1.0 / 1.064, rtol=0.02)


def test_gain_of_beams_is_levelled_and_a_wall_along_a_beam_is_not() -> None:
    gain = np.random.default_rng(2).uniform(0.5, 2.0, 60).astype(np.float32)[:, None]
    gain[30] = 1.8
    image = noise(60, 2000) * gain
    image[30, 200:1700] *= 6.0
    image[7] = 0.0
    out = apply("equalize.beam_gain", image)
    level = np.delete(out.mean(axis=1), [7, 30])
    assert level.std() / level.mean() < 0.05
    assert out[30, 200:1700].mean() > 5.5 * level.mean()
    assert not out[7].any()


def test_background_learns_the_sonars_own_pattern_and_not_an_object() -> None:
    pattern = 1.0 + 0.4 * np.sin(np.arange(900) / 9.0) * np.cos(np.arange(60) / 3.0)[:, None]
    run = stage_on_images("equalize.background", fan_of(noise()))
    for seed in range(60):
        image = noise(seed=seed) * pattern.astype(np.float32)
        image[20:25, 400:420] *= 8.0
        out = run(image)
    assert out[20:25, 400:420].mean() > 3.0 * out.mean()
    image = pattern.astype(np.float32)
    out = run(image)
    assert np.delete(out, slice(380, 440), 1).std() < 0.3 * image.std()
    assert np.isfinite(out).all()


def pose_at(north: float, yaw: float = 0.0) -> Pose:
    attitude = tuple(quat_from_euler(0.0, 0.0, yaw).tolist())
    return Pose(0, 0, 0, (north, 0.0, 5.0), attitude, (0.0, 0.0, 0.0), (0.1, 0.1, 0.1), (0.0, 0.0, 0.0))


@pytest.mark.parametrize("use", ["filter.ping_iir", "filter.ping_median"])
@pytest.mark.parametrize(("north", "yaw"), [(1.0, 0.0), (0.0, np.radians(4.5))])
def test_filters_over_pings_follow_the_vehicle(use: str, north: float, yaw: float) -> None:
    """A static echo ahead stays sharp where the pose is given, and smears where it is not."""
    peaks = []
    for known in (True, False):
        run = stage_on_images(use, fan_of(noise()))
        for k in range(5):
            image = np.ones((60, 900), np.float32)
            beam = round(30 - k * yaw / np.radians(1.5))
            column = round((35.0 - k * north - 10.0) / 0.05)
            image[beam - 1 : beam + 2, column - 2 : column + 3] = 10.0
            out = run(image, PingContext(k * 10**8, pose_at(k * north, k * yaw) if known else None))
        peaks.append(out[beam, column])
    assert peaks[0] > 8.0
    assert peaks[1] < 6.0


def test_filter_over_pings_starts_anew_after_a_pause() -> None:
    run = stage_on_images("filter.ping_iir", fan_of(noise()))
    run(noise(seed=1))
    np.testing.assert_array_equal(run(noise(seed=2), PingContext(10**10, None)), noise(seed=2))


def two_bodies(apart_m: float) -> Bytes:
    beams = fan_bearings(60)
    half = 0.5 * apart_m / 40.0
    intensity = np.ones((60, 1200))
    for bearing in (-half, half):
        intensity += 300.0 * body_echo("half", 1.0, 40.0, bearing, beams, 1200)
    return np.rint(40.0 * np.log10(1.0 + 8.0 * speckle(np.random.default_rng(6), intensity))).astype(np.uint8)


def detections(frame: NDArray[Any], **detect: Any) -> list[Any]:
    stages = ({"use": "equalize.mean_range"}, {"use": "filter.fir"}, {"use": "detect.two_level", **detect})
    return Chain(PipelineSettings(stage=stages)).process(make_ping(frame, scale="log8", scale_factor=40.0)).detections


def test_merged_objects_are_split_and_one_object_is_not() -> None:
    assert len(detections(two_bodies(5.0))) <= 2
    assert len(detections(two_bodies(5.0), split_db=9.0)) == 2
    assert len(detections(two_bodies(0.0), split_db=9.0)) == 1


def test_sizes_are_limits_in_metres() -> None:
    frame = two_bodies(12.0)
    assert len(detections(frame)) == 2
    assert detections(frame, min_extent_m=8.0) == []
    assert detections(frame, max_extent_m=0.5) == []
    assert len(detections(frame, min_extent_m=0.5, max_extent_m=8.0)) == 2


def test_absolute_levels_are_those_of_the_image() -> None:
    frame = np.full((8, 300), 10, np.uint8)
    frame[3:5, 100:120] = 60
    stage = ({"use": "detect.two_level", "levels": "absolute", "low": 20.0, "high": 50.0},)
    assert len(Chain(PipelineSettings(stage=stage)).process(make_ping(frame)).detections) == 1
    stage = ({"use": "detect.two_level", "levels": "absolute", "low": 20.0, "high": 61.0},)
    assert Chain(PipelineSettings(stage=stage)).process(make_ping(frame)).detections == []


@pytest.mark.parametrize("method", ["ca", "goca", "soca", "os"])
def test_cfar_finds_a_body_beside_a_step_of_the_background(method: str) -> None:
    beams = fan_bearings(60)
    intensity = np.ones((60, 1200)) + 400.0 * body_echo("half", 1.5, 40.0, 0.1, beams, 1200)
    intensity[:, 400:] *= 9.0
    frame = np.rint(40.0 * np.log10(1.0 + 8.0 * speckle(np.random.default_rng(3), intensity))).astype(np.uint8)
    stages = ({"use": "filter.fir"}, {"use": "detect.cfar", "method": method})
    found = Chain(PipelineSettings(stage=stages)).process(make_ping(frame, scale="log8", scale_factor=40.0)).detections
    assert any(abs(d.range_m - 40.0) < 1.5 and abs(d.bearing_rad - 0.1) < 0.03 for d in found)
