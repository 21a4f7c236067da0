from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from ods.base.arrays import Floats, Image
from ods.messages import Ping
from ods.pipeline.chain import STABLE_PINGS, Chain
from ods.pipeline.prepared import prepared_chain
from ods.pipeline.prepared.filter_chain import FilterChain
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.prepared.speckle import filtered_speckle
from ods.pipeline.settings import PipelineSettings
from tests.pipeline.pings import body_echo, fan_bearings, make_ping, speckle

RANGE_M, BEARING = 40.0, 0.21


def scene(beams: int = 60, samples: int = 1200, seed: int = 1) -> Floats:
    """Amplitude of one body of radius 1.5 m in speckle."""
    rng = np.random.default_rng(seed)
    intensity = 1.0 + 400.0 * body_echo("half", 1.5, RANGE_M, BEARING, fan_bearings(beams), samples)
    return 10.0 * speckle(rng, intensity)


def scene_of(dtype: str, beams: int = 60) -> NDArray[Any]:
    amplitude = scene(beams)
    return np.minimum(amplitude, 255.0).astype(np.uint8) if dtype == "u1" else amplitude.astype(dtype)


@pytest.mark.parametrize("beams", [48, 60, 256, 512])
@pytest.mark.parametrize("dtype", ["u1", "<u2", "<f4"])
def test_body_is_found_whatever_the_sonar(beams: int, dtype: str) -> None:
    result = Chain(PipelineSettings()).process(make_ping(scene_of(dtype, beams)))
    assert 1 <= len(result.detections) <= 2
    body = max(result.detections, key=lambda detection: detection.cells)
    assert body.range_m == pytest.approx(RANGE_M, abs=0.6)
    assert body.bearing_rad == pytest.approx(BEARING, abs=0.02)
    assert body.radius_m == pytest.approx(1.5, rel=0.35)
    assert body.snr_db > 12.0
    assert result.usable
    assert (result.seq, result.ping_number, result.t_ns, result.t_rx_ns, result.utc_ns) == (3, 77, 10, 20, 30)


def test_uneven_beams_give_the_bearing_of_the_table() -> None:
    uneven = fan_bearings(60) + 0.01 * np.sin(np.arange(60))
    even = Chain(PipelineSettings()).process(make_ping(scene_of("u1")))
    result = Chain(PipelineSettings()).process(make_ping(scene_of("u1"), bearing_rad=uneven.tolist()))
    beam = int(np.abs(fan_bearings(60) - even.detections[0].bearing_rad).argmin())
    shift = result.detections[0].bearing_rad - even.detections[0].bearing_rad
    assert shift == pytest.approx(uneven[beam] - fan_bearings(60)[beam], abs=0.012)


def test_planes_are_processed_one_by_one() -> None:
    frame = np.vstack([scene_of("u1"), np.zeros((60, 1200), np.uint8), scene_of("u1")])
    ping = make_ping(
        frame,
        planes=3,
        bearing_rad=fan_bearings(60).tolist() * 3,
        elevation_rad=[0.2] * 60 + [0.0] * 60 + [-0.2] * 60,
    )
    mask = np.zeros(frame.shape, np.int32)
    result = Chain(PipelineSettings()).process(ping, mask)
    single = Chain(PipelineSettings()).process(make_ping(scene_of("u1"))).detections
    count = len(single)
    assert [d.elevation_rad for d in result.detections] == pytest.approx([0.2] * count + [-0.2] * count)
    assert [d.range_m for d in result.detections] == [d.range_m for d in single] * 2
    assert result.sector.half_vertical_rad == pytest.approx(0.2 + np.radians(10.0))
    assert result.sector.plane_half_rad == pytest.approx(np.radians(10.0))
    assert set(np.unique(mask[:60])) == set(range(count + 1))
    assert set(np.unique(mask[120:])) == {0, *range(count + 1, 2 * count + 1)}


def test_mask_marks_the_cells_of_each_detection() -> None:
    ping = make_ping(scene_of("u1"))
    mask = np.zeros((60, 1200), np.int32)
    result = Chain(PipelineSettings()).process(ping, mask)
    frame = scene_of("u1")
    for number, detection in enumerate(result.detections, 1):
        assert (mask == number).sum() == 2 * detection.cells  # of two samples each
        assert frame[mask == number].max() == detection.amplitude


def test_samples_under_the_minimum_range_do_not_count() -> None:
    frame = scene_of("u1")
    frame[:, :40] = 255
    frame[10:20, 10:30] = 0
    chain = Chain(PipelineSettings(min_range_m=2.0))
    result = chain.process(make_ping(frame))
    assert result.sector.range_min_m == pytest.approx(1.975)
    assert all(detection.range_m > 30.0 for detection in result.detections)
    with pytest.raises(PingError, match="min_range_m"):
        Chain(PipelineSettings(min_range_m=60.0)).process(make_ping(frame))


def test_sector_is_that_of_the_beams_and_samples() -> None:
    sector = Chain(PipelineSettings(vertical_half_deg=7.0)).process(make_ping(scene_of("u1"), range0_m=5.0)).sector
    assert sector.bearing_max_rad == pytest.approx(np.pi / 4.0)
    assert sector.bearing_min_rad == pytest.approx(-np.pi / 4.0)
    assert sector.range_min_m == pytest.approx(5.0 - 0.025)
    assert sector.range_max_m == pytest.approx(5.0 + 1199.5 * 0.05)
    assert sector.half_vertical_rad == pytest.approx(np.radians(7.0))
    assert b"plane_half_rad" not in msgspec.msgpack.encode(sector)  # as recordings of before it


@pytest.mark.parametrize("level", [0, 17, 255])
def test_drop_out_of_the_whole_image_is_not_usable(level: int) -> None:
    result = Chain(PipelineSettings()).process(make_ping(np.full((60, 400), level, np.uint8)))
    assert not result.usable
    assert result.detections == []


def test_speckle_alone_gives_almost_no_detection() -> None:
    rng = np.random.default_rng(8)
    chain = Chain(PipelineSettings())
    found = 0
    for _ in range(40):
        amplitude = np.rint(40.0 * np.log10(1.0 + 30.0 * speckle(rng, np.ones((60, 2000)))))
        ping = make_ping(amplitude.astype(np.uint8), scale="log8", scale_factor=40.0)
        found += len(chain.process(ping).detections)
    assert found <= 4  # under 0.1 an image


def test_geometry_may_change_from_ping_to_ping() -> None:
    chain = Chain(PipelineSettings())
    for beams in (60, 48, 60):
        ping = make_ping(scene_of("u1", beams))
        assert chain.process(ping) == Chain(PipelineSettings()).process(ping)


def bad(**changes: Any) -> Ping:
    return make_ping(scene_of("u1"), **changes)


@pytest.mark.parametrize(
    ("ping", "complaint"),
    [
        (bad(data=b"short"), "do not hold"),
        (bad(bearing_rad=[0.0] * 59), "59 entries for 60 beams"),
        (bad(bearing_rad=[0.1] * 60), "does not increase"),
        (bad(bearing_rad=fan_bearings(60)[::-1].tolist()), "does not increase"),
        (bad(bearing_rad=[*fan_bearings(60)[:-1], float("nan")]), "not angles"),
        (bad(bearing_rad=[*fan_bearings(60)[:-1], 1e9]), "not angles"),
        (bad(elevation_rad=[float("inf")] * 60), "not angles"),
        (bad(beam_width_rad=[0.0] * 60), "not widths"),
        (bad(beam_width_rad=[0.1] * 3), "3 entries"),
        (bad(planes=7), "do not make 7 planes"),
        (bad(dr_m=0.0), "dr_m"),
        (bad(dr_m=float("nan")), "dr_m"),
        (bad(range0_m=float("-inf")), "range0_m"),
        (bad(scale="log8", scale_factor=0.0), "scale_factor"),
        (bad(scale="db", scale_factor=float("nan")), "scale_factor"),
        (make_ping(np.full((3, 50), np.nan, np.float32)), "not finite"),
        (make_ping(np.full((3, 50), np.inf, np.float32)), "not finite"),
    ],
)
def test_bad_pings_raise_one_error_and_the_next_is_processed(ping: Ping, complaint: str) -> None:
    chain = Chain(PipelineSettings())
    with pytest.raises(PingError, match=complaint) as caught:
        chain.process(ping)
    assert "\n" not in str(caught.value)
    assert chain.process(make_ping(scene_of("u1"))).detections


@pytest.mark.parametrize("shape", [(1, 1), (1, 300), (200, 1), (2, 2), (3, 40)])
def test_degenerate_shapes_do_no_harm(shape: tuple[int, int]) -> None:
    frame = np.random.default_rng(0).integers(0, 255, shape).astype(np.uint8)
    result = Chain(PipelineSettings(min_range_m=0.0)).process(make_ping(frame))
    for detection in result.detections:
        assert np.isfinite([detection.range_m, detection.bearing_rad, detection.radius_m, detection.snr_db]).all()


def test_geometries_that_do_not_last_are_learnt_in_a_hurry(monkeypatch: pytest.MonkeyPatch) -> None:
    """A tenth of the cells as long as they change at each ping, all of them once one has lasted."""
    learnt: list[int] = []

    def speckle_of(filters: FilterChain, stride: int, cells: int, _: object) -> Iterator[Iterator[Image]]:
        learnt.append(cells)
        return filtered_speckle(filters, stride, 2000)

    monkeypatch.setattr(prepared_chain, "filtered_speckle", speckle_of)
    chain = Chain(PipelineSettings(stage=({"use": "detect.two_level", "levels": "false_alarm"},)), learnt_cells=1000)
    frame = np.random.default_rng(0).integers(0, 255, (20, 60)).astype(np.uint8)
    for k in range(4):
        chain.process(make_ping(frame, dr_m=0.05 + 0.01 * k))
    assert learnt == [1000, 100, 100, 100]
    for _ in range(3 * STABLE_PINGS):
        chain.process(make_ping(frame, dr_m=0.08))
    assert learnt == [1000, 100, 100, 100, 1000]
    chain.process(make_ping(frame, dr_m=0.09))
    assert learnt[5:] == [1000]
    assert chain.geometry_changes == 4


@pytest.mark.parametrize("detector", [{"use": "detect.cfar"}, {"use": "detect.two_level", "levels": "false_alarm"}])
def test_detectors_learn_once_where_ranges_follow_a_sound_speed_that_changes(
    detector: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And echoes are where the newest sound speed says; between two geometries there is nothing to learn either."""
    learnt: list[int] = []

    def speckle_of(filters: FilterChain, stride: int, cells: int, _: object) -> Iterator[Iterator[Image]]:
        learnt.append(cells)
        return filtered_speckle(filters, stride, 2000)

    monkeypatch.setattr(prepared_chain, "filtered_speckle", speckle_of)
    chain, frame = Chain(PipelineSettings(stage=(detector,), min_range_m=0.0)), scene_of("u1")
    places = []
    for k in range(20):
        dr_m = 0.05 * (1480.0 + 3.0 * k) / 1500.0
        echoes = chain.process(make_ping(frame, dr_m=dr_m)).detections
        places.append(max(echoes, key=lambda echo: echo.snr_db).range_m / dr_m)
    assert len(learnt) == 1
    assert places == pytest.approx([places[0]] * 20, rel=1e-6)
    for k in range(20):
        chain.process(make_ping(frame, dr_m=0.05 if k % 2 else 0.1))
    assert len(learnt) == 2
    assert chain.geometry_changes == 20
    for k in range(30):  # learnt in a hurry, and anew as it lasts, though its ranges go on changing
        chain.process(make_ping(frame, dr_m=0.2 * (1.0 + 1e-4 * k)))
    cells = learnt[-1]
    assert learnt[2:] == [cells // 10, cells]
