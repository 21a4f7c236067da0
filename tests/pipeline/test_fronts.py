"""Fronts: a body's echo sets in at once in all of its beams, a crest's grows and fades. Images are numpy's own."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.signal import correlate

from ods.base.arrays import Floats, Floats32
from ods.pipeline.chain import Chain
from ods.pipeline.fronts.judge import BEAMS, BEFORE, CELLS, LEAST_FRONT, LeadingEdgeJudge, can_be_judged
from ods.pipeline.fronts.network import learnt, network_of
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.image_layout import RangeInterval, layout
from ods.pipeline.image.samples.amplitude import sample_scale
from ods.pipeline.settings import DEFAULT_STAGES, AttentionSettings, PipelineSettings
from tests.pipeline.pings import make_ping

STEP_RAD, DR_M, SAMPLES = math.radians(1.5), 0.05, 1200
NO_RINGS = AttentionSettings(near_m=0.0, subsample=2)
ALL_RANGES = RangeInterval(0.0, np.inf)
AMPLITUDE = sample_scale(np.dtype(np.float32), "linear", 1.0)


def fan_of(beams: int = 60, step_rad: float = STEP_RAD, dr_m: float = DR_M) -> Fan:
    bearing = np.linspace(-0.5, 0.5, beams, dtype=np.float64) * step_rad * (beams - 1)
    return Fan(bearing, np.full(beams, step_rad), SAMPLES, dr_m, dr_m)


def fronts_of(fan: Fan, first: int = 0, subsample: int = 2) -> LeadingEdgeJudge:
    attention = AttentionSettings(near_m=0.0, subsample=subsample)
    return LeadingEdgeJudge(layout(fan, slice(0, len(fan.bearing_rad)), first, [ALL_RANGES], attention, 0))


def places(*places: tuple[int, float]) -> tuple[Floats, Floats]:
    """Return the bearings and near edges of echoes in beams of `fan_of()`."""
    beams, near_m = zip(*places, strict=True)
    return fan_of().bearing_rad[list(beams)], np.array(near_m)


def speckled(mean: Floats, seed: int) -> Floats32:
    """Amplitudes of speckle about mean intensities."""
    rng = np.random.default_rng(seed)
    return np.sqrt(mean * rng.exponential(size=mean.shape)).astype(np.float32)


@pytest.mark.parametrize("first", [0, 7])
@pytest.mark.parametrize("subsample", [1, 2, 3])
def test_a_window_lies_around_the_place_where_the_echo_sets_in(first: int, subsample: int) -> None:
    """To half a cell, whatever columns and least range the chain has."""
    fan = fan_of()
    image = np.ones((60, SAMPLES), np.float32)
    near_m = 30.0
    image[20, round(near_m / DR_M) - 1 :] = 100.0  # sample k lies at (k + 1) dr
    part = Fan(fan.bearing_rad, fan.beam_width_rad, SAMPLES - first, DR_M * (1 + first), DR_M)
    (window,) = fronts_of(part, first, subsample).windows(*places((20, near_m)), image, AMPLITUDE)
    (rises,) = np.nonzero(np.diff(window[BEAMS // 2]) > 10.0)
    assert abs(rises[0] + 1 - BEFORE) <= 1
    assert np.ptp(window[BEAMS // 2 + 1]) == 0.0


@given(gain=st.floats(1e-6, 1e6), seed=st.integers(0, 99))
def test_levels_know_no_gain(gain: float, seed: int) -> None:
    image = speckled(np.ones((60, SAMPLES)), seed)
    echoes = places((0, 0.1), (30, 25.0), (59, 59.9))
    fronts = fronts_of(fan_of())
    one, other = (fronts.windows(*echoes, times * image, AMPLITUDE) for times in (np.float32(1.0), np.float32(gain)))
    np.testing.assert_allclose(one, other, atol=1e-2)


@pytest.mark.parametrize("of_all", [0.0, 1.0, 1e15])
def test_an_image_without_anything_gives_numbers(of_all: float) -> None:
    window = fronts_of(fan_of()).windows(*places((3, 1.0)), np.full((60, SAMPLES), of_all, np.float32), AMPLITUDE)
    assert np.abs(window).max() < 1e-3
    assert np.isfinite(learnt().scores(window)).all()


def test_counts_and_their_amplitudes_are_judged_alike() -> None:
    counts = (40.0 * speckled(np.ones((60, SAMPLES)), 1)).astype(np.uint16)
    fronts, echoes = fronts_of(fan_of()), places((30, 25.0))
    of_counts = fronts.windows(*echoes, counts, sample_scale(np.dtype(np.uint16), "linear", 1.0))
    of_amplitudes = fronts.windows(*echoes, counts.astype(np.float32), AMPLITUDE)
    np.testing.assert_allclose(of_counts, of_amplitudes, atol=1e-3)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_a_log_of_amplitudes_is_judged_as_they_are(dtype: type) -> None:
    """In steps of 0.5 dB."""
    amplitude = 40.0 * speckled(np.ones((60, SAMPLES)), 1)
    counts = np.clip(np.round(40.0 * np.log10(amplitude + 1e-3)), 0, 255).astype(dtype)
    fronts, echoes = fronts_of(fan_of()), places((30, 25.0))
    of_counts = fronts.windows(*echoes, counts, sample_scale(np.dtype(dtype), "db", 0.5))
    np.testing.assert_allclose(of_counts, fronts.windows(*echoes, amplitude, AMPLITUDE), atol=1.0)


STEPS = ((1, 2), (2, 2), (1, 2))


def random_weights(rng: np.random.Generator, channels: tuple[int, ...], hidden: int) -> dict[str, Floats32]:
    arrays: dict[str, Floats32] = {"steps": np.array(STEPS, np.float32)}
    before, shape = 1, (BEAMS, CELLS)
    for k, (count, around) in enumerate(zip(channels, [(3, 5), (3, 5), (3, 3)], strict=True)):
        arrays[f"convolution{k}"] = rng.normal(size=(*around, before, count)).astype(np.float32)
        arrays[f"convolution{k}_bias"] = rng.normal(size=count).astype(np.float32)
        before, shape = count, (-(-shape[0] // STEPS[k][0]), -(-shape[1] // STEPS[k][1]))
    for name, into, out in [("hidden", before * shape[0] * shape[1], hidden), ("last", hidden, 1)]:
        arrays[name] = rng.normal(size=(into, out)).astype(np.float32)
        arrays[f"{name}_bias"] = rng.normal(size=out).astype(np.float32)
    return arrays


@pytest.mark.parametrize(("channels", "hidden"), [((16, 24, 16), 48), ((16, 32, 16), 40)])
def test_a_network_of_other_sizes_than_the_kernel_is_for_scores_nothing(channels: tuple[int, ...], hidden: int) -> None:
    network = network_of(random_weights(np.random.default_rng(0), channels, hidden))
    assert np.isnan(network.scores(np.ones((2, BEAMS, CELLS), np.float32))).all()


def test_the_network_is_what_another_correlation_makes_of_its_weights() -> None:
    rng = np.random.default_rng(0)
    arrays = random_weights(rng, (16, 32, 16), 48)
    windows = 10.0 * rng.normal(size=(3, BEAMS, CELLS)).astype(np.float32)

    for window, score in zip(windows, network_of(arrays).scores(windows), strict=True):
        seen = window[..., None] / 10.0
        for k, (beams, cells) in enumerate(STEPS):
            weights = arrays[f"convolution{k}"]
            made = [
                sum(correlate(seen[..., i], weights[..., i, o], "same", "direct") for i in range(seen.shape[2]))
                for o in range(weights.shape[3])
            ]
            seen = np.maximum(np.stack(made, axis=-1) + arrays[f"convolution{k}_bias"], 0.0)[::beams, ::cells]
        hidden = np.maximum(seen.ravel() @ arrays["hidden"] + arrays["hidden_bias"], 0.0)
        assert score == pytest.approx((hidden @ arrays["last"] + arrays["last_bias"])[0], rel=1e-3, abs=1e-2)


def body(across: Floats, behind: Floats) -> Floats:
    """A front that is met at once, and darkens over 0.4 m; of a point, in beams of 1.5 deg."""
    return np.where(behind >= 0.0, np.exp(-np.maximum(behind, 0.0) / 0.2), 0.0) * np.exp2(-4.0 * across**2)


def crest(across: Floats, behind: Floats) -> Floats:
    """What shines of a slope: it grows and fades within a metre, and runs on to the sides at other ranges."""
    return np.exp(-0.5 * ((behind - 0.5 - 0.4 * across) / 0.45) ** 2) * np.exp2(-((across / 2.0) ** 2))


def bed_of_patches(shape: float, seed: int) -> Floats32:
    """Return speckle over patches of 2 beams and 1 m whose intensity follows a gamma law."""
    rng = np.random.default_rng(seed)
    patches = rng.gamma(shape, 1.0 / shape, (30, SAMPLES // 20))
    return speckled(40.0 * np.repeat(np.repeat(patches, 2, axis=0), 20, axis=1), seed)


def share_of(shape: Callable[[Floats, Floats], Floats], over_db: float, least: float) -> float:
    """Return the share of 60 such echoes that have at least such a front, so far over the mean of a bed of patches."""
    fan = fan_of()
    judge = LeadingEdgeJudge(layout(fan, slice(0, 60), 0, [ALL_RANGES], NO_RINGS, 0))
    count = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        patches = np.kron(rng.gamma(1.0, 1.0, (30, SAMPLES // 20)), np.ones((2, 20)))
        near_m, beam = 30.0 + rng.uniform(-0.1, 0.1), int(rng.integers(8, 52))
        across = np.repeat(np.arange(60.0)[:, None] - beam, SAMPLES, axis=1)
        behind = np.repeat(DR_M * np.arange(1.0, SAMPLES + 1.0)[None] - near_m, 60, axis=0)
        image = speckled(patches + 10.0 ** (over_db / 10.0) * shape(across, behind), seed)
        (front,) = judge.of(*places((beam, near_m)), image, AMPLITUDE).tolist()
        count += front > least
    return count / 60.0


def test_what_sets_in_as_a_body_does_is_reported_and_a_crest_is_not() -> None:
    """Drawn without the simulator, over a bed of patches."""
    assert share_of(body, 22.0, 0.5) > 0.9
    assert share_of(crest, 18.0, 0.5) < 0.1
    assert share_of(crest, 18.0, LEAST_FRONT) < 0.4


def test_of_fine_beams_a_window_has_those_a_beam_width_apart() -> None:
    """Beams of 1.5 degrees every 0.25 make the windows of every sixth of them."""
    fine = replace(fan_of(360, math.radians(0.25)), beam_width_rad=np.full(360, STEP_RAD))
    coarse = Fan(fine.bearing_rad[::6].copy(), np.full(60, STEP_RAD), SAMPLES, DR_M, DR_M)
    image = speckled(np.ones((360, SAMPLES)), 4)
    echoes = fine.bearing_rad[[120, 180]], np.array([20.0, 30.0])
    of_fine, of_coarse = (
        fronts_of(fan).windows(*echoes, samples, AMPLITUDE) for fan, samples in [(fine, image), (coarse, image[::6])]
    )
    np.testing.assert_array_equal(of_fine, of_coarse)


def fine_fan(beams: int, width_deg: float) -> Fan:
    """Return a fan of beams 0.25 degrees apart."""
    return replace(fan_of(beams, math.radians(0.25)), beam_width_rad=np.full(beams, math.radians(width_deg)))


def test_sonars_are_judged_by_the_width_of_their_beams_whatever_their_number() -> None:
    assert can_be_judged(fan_of(dr_m=0.1))
    assert not can_be_judged(fan_of(dr_m=0.2))
    assert not can_be_judged(fan_of(beams=BEAMS))
    assert not can_be_judged(fan_of(beams=1))
    assert can_be_judged(fine_fan(512, 1.0))
    assert can_be_judged(fine_fan(512, 1.5))
    assert not can_be_judged(fine_fan(512, 0.5))
    assert not can_be_judged(fine_fan(512, 3.0))
    assert not can_be_judged(fine_fan(4 * BEAMS, 1.0))


def test_windows_follow_beams_that_lie_wider_apart_at_the_edges_of_a_fan() -> None:
    """As those of the Oculus do: of each, those about as far apart as it is wide."""
    bearing = np.arcsin(np.linspace(-0.9, 0.9, 512))
    fan = Fan(bearing, np.full(512, math.radians(1.0)), SAMPLES, DR_M, DR_M)
    assert can_be_judged(fan)
    ramp = np.repeat(np.exp(bearing)[:, None], SAMPLES, axis=1).astype(np.float32)
    windows = fronts_of(fan).windows(bearing[[60, 256]], np.array([30.0, 30.0]), ramp, AMPLITUDE)
    apart_db = np.diff(windows[:, :, 0], axis=1)
    np.testing.assert_allclose(apart_db, 20.0 * math.log10(math.e) * math.radians(1.0), rtol=0.35)


def test_no_echo_is_no_work() -> None:
    judge = LeadingEdgeJudge(layout(fan_of(), slice(0, 60), 0, [ALL_RANGES], NO_RINGS, 0))
    nowhere = np.empty(0)
    assert judge.of(nowhere, nowhere, np.empty((60, SAMPLES), np.float32), AMPLITUDE).size == 0


def test_over_a_rough_bed_all_echoes_tell_their_front_and_faint_ones_are_those_like_a_bodys() -> None:
    chain = Chain(PipelineSettings())
    found = [chain.process(make_ping(bed_of_patches(0.1, seed))) for seed in range(6)]
    assert all(each.detections and each.faint for each in found)
    assert all(0.0 < echo.front <= 1.0 for each in found for echo in each.detections)
    assert all(echo.front > LEAST_FRONT for each in found for echo in each.faint)


def test_over_an_even_bed_no_echo_tells_its_front_and_faint_ones_are_those_at_the_raised_level() -> None:
    """Its regions reach a little higher than speckle, which raises levels there."""
    *filters, detector = DEFAULT_STAGES
    chain, of_all = (
        Chain(PipelineSettings(stage=(*filters, {**detector, "faint": faint, "high": 5.0}))) for faint in (0.5, 0.0)
    )
    fewer = 0
    for seed in range(6):
        ping = make_ping(bed_of_patches(6.0, seed))
        found, all_found = chain.process(ping), of_all.process(ping)
        assert {echo.front for echo in found.detections + all_found.faint} <= {0.0}
        assert found.detections == all_found.detections
        assert {echo.near_m for echo in found.faint} <= {echo.near_m for echo in all_found.faint}
        fewer += len(all_found.faint) - len(found.faint)
    assert fewer > 5


def test_in_calm_water_no_echo_tells_its_front() -> None:
    image = speckled(np.ones((60, SAMPLES)), 3)
    image[28:31, 600:610] = 30.0
    found = Chain(PipelineSettings()).process(make_ping(image))
    assert found.detections
    assert not found.faint
    assert {echo.front for echo in found.detections} == {0.0}
