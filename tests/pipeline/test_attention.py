"""Focus of attention: near ranges at each ping, far ones in turn, fewer samples."""

import numpy as np
import pytest

from ods.base.arrays import Bytes
from ods.pipeline.chain import Chain
from ods.pipeline.prepared.plan import make_plan
from ods.pipeline.settings import DEFAULT_STAGES, AttentionSettings, PipelineSettings
from tests.pipeline.pings import body_echo, fan_bearings, make_ping, speckle

BODIES = ((15.0, 0.2), (40.0, -0.3), (70.0, 0.1), (92.0, 0.4))


def frame() -> Bytes:
    beams = fan_bearings(60)
    intensity = np.ones((60, 2000))
    for range_m, bearing in BODIES:
        intensity += 200.0 * body_echo("half", 1.5, range_m, bearing, beams, 2000)
    return np.rint(40.0 * np.log10(1.0 + 8.0 * speckle(np.random.default_rng(5), intensity))).astype(np.uint8)


STAGES = (*DEFAULT_STAGES[:-1], {"use": "detect.two_level", "high": 8.0})
"""High enough that no speckle is found: what is compared is where the bodies are."""


def attentive(**values: object) -> Chain:
    return Chain(PipelineSettings(stage=STAGES, attention=AttentionSettings(**values)))  # type: ignore[arg-type]


def found(chain: Chain) -> list[tuple[float, float]]:
    result = chain.process(make_ping(frame(), scale="log8", scale_factor=40.0))
    return sorted((d.range_m, d.bearing_rad) for d in result.detections)


def test_each_body_is_found_when_its_ring_has_its_turn() -> None:
    chain = attentive(near_m=25.0, every=3)
    every = [found(chain) for _ in range(6)]
    for phase, (range_m, bearing) in enumerate(BODIES[1:]):  # one ring each: 25-50, 50-75, 75-100 m
        for k in range(6):
            near, *far = every[k]
            assert near == pytest.approx(BODIES[0], abs=0.6)
            if k % 3 == phase:
                assert len(far) == 1
                assert far[0] == pytest.approx((range_m, bearing), abs=0.8)


def test_what_was_looked_at_is_reported() -> None:
    chain = attentive(near_m=25.0, every=3)
    ping = make_ping(frame(), scale="log8", scale_factor=40.0)
    processed = [chain.process(ping).processed_ranges_m for _ in range(3)]
    assert processed[0] == [(0.0, 25.0), (25.0, pytest.approx(50.0))]
    assert processed[1] == [(0.0, 25.0), (pytest.approx(50.0), pytest.approx(75.0))]
    assert attentive().process(ping).processed_ranges_m == []


def test_body_on_a_border_is_seen_once_and_whole() -> None:
    chain = attentive(near_m=40.0, every=2)
    counts = [sum(abs(r - 40.0) < 2.0 for r, _ in found(chain)) for _ in range(2)]
    assert sum(counts) in (1, 2)
    assert max(counts) == 1


@pytest.mark.parametrize("subsample", [2, 3, 4])
def test_subsampling_finds_the_same_bodies(subsample: int) -> None:
    ping = make_ping(frame(), scale="log8", scale_factor=40.0)
    whole, fewer = (
        sorted((d.near_m, d.bearing_rad) for d in chain.process(ping).detections)
        for chain in (attentive(), attentive(subsample=subsample))
    )
    assert len(whole) == len(fewer) == len(BODIES)
    np.testing.assert_allclose(np.array(fewer), np.array(whole), atol=0.2 * subsample)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_linear_samples_side_by_side_are_measured_where_they_are(dtype: type) -> None:
    """The third turn's image is 0 to 27 m and 73 m to the end; both bodies are found as in the whole image."""
    intensity = np.ones((60, 2000))
    places = ((15.0, 0.2), (85.0, -0.1))
    for range_m, bearing in places:
        intensity += 200.0 * body_echo("half", 1.5, range_m, bearing, fan_bearings(60), 2000)
    ping = make_ping((12.0 * speckle(np.random.default_rng(7), intensity)).clip(0, 255).astype(dtype))
    whole = sorted(attentive().process(ping).detections, key=lambda d: d.range_m)
    chain = attentive(near_m=25.0, every=3, subsample=2, margin_m=2.0)
    mask = np.zeros((60, 2000), np.int32)
    chain.process(ping)
    chain.process(ping)
    result = chain.process(ping, mask)
    assert len(result.detections) == len(whole) == 2
    for number, (new, old) in enumerate(zip(result.detections, whole, strict=True), 1):
        assert new.near_m == pytest.approx(old.near_m, abs=0.4)
        assert new.bearing_rad == pytest.approx(old.bearing_rad, abs=0.01)
        assert new.amplitude == old.amplitude
        beams, columns = np.nonzero(mask == number)
        assert new.radius_m == pytest.approx(old.radius_m, abs=2.0 * (new.sigma_radius_m + old.sigma_radius_m))
        assert abs(0.05 * columns.mean() - old.range_m) < 2.0
        assert abs(fan_bearings(60)[beams].mean() - old.bearing_rad) < 0.05


def test_nothing_reaches_across_the_seam() -> None:
    """Two walls that margins cut, one on each side of the seam, stay two regions."""
    intensity = np.ones((60, 2000))
    intensity[25:35, 490:560] = intensity[25:35, 1440:1510] = 400.0
    ping = make_ping((8.0 * speckle(np.random.default_rng(7), intensity)).clip(0, 255).astype(np.uint8))
    chain = attentive(near_m=25.0, every=3, margin_m=2.0)
    ranges = [[d.range_m for d in chain.process(ping).detections] for _ in range(3)]
    assert all(abs(r - 26.2) < 2.0 or abs(r - 73.7) < 2.0 for turn in ranges for r in turn)


def test_stage_over_pings_sees_near_ranges_at_each_ping() -> None:
    """A near body shown once is gone at the next ping's median; with an image a turn it would last for three."""
    stages = (
        {"use": "equalize.mean_range"},
        {"use": "filter.fir"},
        {"use": "filter.ping_median"},
        {"use": "detect.two_level"},
    )
    settings = PipelineSettings(stage=stages, attention=AttentionSettings(near_m=25.0, every=3))
    chain = Chain(settings)
    body, empty = np.ones((60, 2000)), np.ones((60, 2000))
    body += 200.0 * body_echo("half", 1.5, 15.0, 0.2, fan_bearings(60), 2000)
    rng = np.random.default_rng(3)
    found = []
    for number, intensity in enumerate([body, body, body, empty, empty, empty]):
        samples = (10.0 * speckle(rng, intensity)).clip(0, 255).astype(np.uint8)
        result = chain.process(make_ping(samples, t_ns=number * 10**8))
        found.append(any(abs(d.range_m - 15.0) < 2.0 for d in result.detections))
    assert found == [True, True, True, True, False, False]


def test_masks_lie_where_the_bodies_are() -> None:
    mask = np.zeros((60, 2000), np.int32)
    result = attentive(subsample=2, near_m=25.0, every=1).process(
        make_ping(frame(), scale="log8", scale_factor=40.0), mask
    )
    for number, detection in enumerate(result.detections, 1):
        columns = np.flatnonzero((mask == number).any(axis=0))
        assert columns.min() * 0.05 - 2.0 < detection.range_m < columns.max() * 0.05 + 2.0


def test_paper_s_setting_leaves_a_third_of_the_cells_to_process() -> None:
    """Near fifth at each ping, the rest in four turns, two samples to one: [SSIE] gained at least three times."""
    settings = PipelineSettings(attention=AttentionSettings(near_m=20.0, every=4, subsample=2))
    plan = make_plan(make_ping(frame()), settings)
    cells = [sum(image.fan.samples for image in plan.images if image.phase in (None, k)) for k in range(4)]
    assert max(cells) <= 2000 / 3
