"""Focus of attention: near ranges at each ping, far ones in turn, fewer samples."""

import numpy as np
import pytest
from numpy.typing import NDArray
from pipeline_pings import body_echo, fan_bearings, make_ping, speckle

from ods.pipeline.chain import Chain
from ods.pipeline.plan import EVERY_TURN, make_plan
from ods.pipeline.settings import AttentionSettings, PipelineSettings

BODIES = ((15.0, 0.2), (40.0, -0.3), (70.0, 0.1), (92.0, 0.4))


def frame() -> NDArray[np.uint8]:
    beams = fan_bearings(60)
    intensity = np.ones((60, 2000))
    for range_m, bearing in BODIES:
        intensity += 200.0 * body_echo("half", 1.5, range_m, bearing, beams, 2000)
    return np.rint(40.0 * np.log10(1.0 + 8.0 * speckle(np.random.default_rng(5), intensity))).astype(np.uint8)


def attentive(**values: object) -> Chain:
    return Chain(PipelineSettings(attention=AttentionSettings(**values)))  # type: ignore[arg-type]


def found(chain: Chain) -> list[tuple[float, float]]:
    result = chain.process(make_ping(frame(), scale="log8", scale_factor=40.0))
    return sorted((d.range_m, d.bearing_rad) for d in result.detections)


def test_each_body_is_found_when_its_ring_has_its_turn() -> None:
    chain = attentive(near_m=25.0, every=3)
    every = [found(chain) for _ in range(6)]
    for turn, (range_m, bearing) in enumerate(BODIES[1:]):  # one ring each: 25-50, 50-75, 75-100 m
        for k in range(6):
            near, *far = every[k]
            assert near == pytest.approx(BODIES[0], abs=0.6)
            if k % 3 == turn:
                assert len(far) == 1
                assert far[0] == pytest.approx((range_m, bearing), abs=0.8)


def test_what_was_looked_at_is_told() -> None:
    chain = attentive(near_m=25.0, every=3)
    ping = make_ping(frame(), scale="log8", scale_factor=40.0)
    looked = [chain.process(ping).looked for _ in range(3)]
    assert looked[0] == [(0.0, 25.0), (25.0, pytest.approx(50.0))]
    assert looked[1] == [(0.0, 25.0), (pytest.approx(50.0), pytest.approx(75.0))]
    assert attentive().process(ping).looked == []


def test_body_on_a_border_is_seen_once_and_whole() -> None:
    chain = attentive(near_m=40.0, every=2)
    counts = [sum(abs(r - 40.0) < 2.0 for r, _ in found(chain)) for _ in range(2)]
    assert sum(counts) in (1, 2)
    assert max(counts) == 1


@pytest.mark.parametrize("subsample", [2, 3, 4])
def test_subsampling_finds_the_same_bodies(subsample: int) -> None:
    whole, fewer = found(attentive()), found(attentive(subsample=subsample))
    assert len(whole) == len(fewer) == len(BODIES)
    np.testing.assert_allclose(np.array(fewer), np.array(whole), atol=0.5)


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
    cells = [sum(part.fan.samples for part in plan.parts if part.turn in (EVERY_TURN, k)) for k in range(plan.turns)]
    assert max(cells) <= 2000 / 3
