"""What goes wrong in real images [SSIE]: each failure with truth. 8-bit log counts of speckle of mean intensity 1."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from ods.assess.images.sea import sea_images
from ods.base.arrays import Floats
from ods.messages import Detection
from ods.pipeline.chain import Chain
from ods.pipeline.image.fan import Fan
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.settings import DEFAULT_STAGES, PipelineSettings
from ods.pipeline.stage.params import BUILT_IN
from tests.pipeline.pings import body_echo, fan_bearings, make_ping, speckle
from tests.pipeline.steps import stage_on_images

pytestmark = pytest.mark.slow

BEARINGS = fan_bearings(60)
GATE = 4.0
"""Standard deviations: the tracker's `gate_sigmas`."""


def found(intensity: Floats, seed: int = 1, chain: Chain | None = None) -> list[Detection]:
    """Detections of the default chain in speckle of this mean intensity."""
    counts = np.rint(40.0 * np.log10(1.0 + 8.0 * speckle(np.random.default_rng(seed), intensity)))
    ping = make_ping(np.minimum(counts, 255.0).astype(np.uint8), scale="log8", scale_factor=40.0)
    return (chain or Chain(PipelineSettings())).process(ping).detections


def body(range_m: float, bearing: float, radius: float = 1.5, snr_db: float = 20.0) -> Floats:
    return np.asarray(10.0 ** (snr_db / 10.0) * body_echo("half", radius, range_m, bearing, BEARINGS, 2000))


def hits(detections: list[Detection], range_m: float, bearing: float) -> int:
    return sum(np.hypot(d.range_m - range_m, range_m * (d.bearing_rad - bearing)) < 2.5 for d in detections)


def test_drop_outs_are_no_echoes_and_hide_only_themselves() -> None:
    intensity = 1.0 + body(40.0, 0.1) + body(60.0, -0.2)
    for column in (1560, 1640):  # 78 and 82 m, as in the paper's image
        intensity[:, column : column + 8] = 1e-6
    detections = found(intensity)
    assert hits(detections, 40.0, 0.1) == hits(detections, 60.0, -0.2) == 1
    assert len(detections) == 2


def test_belts_of_the_gain_are_no_echoes() -> None:
    intensity = 1.0 + body(55.0, 0.1) + body(75.0, -0.2) + body(30.0, 0.3)
    intensity[:, 1000:1200] *= 0.3  # a dark belt at 50 to 60 m
    intensity[:, 1400:1600] *= 4.0  # a light one at 70 to 80 m
    detections = found(intensity)
    assert [hits(detections, *place) for place in ((55.0, 0.1), (75.0, -0.2), (30.0, 0.3))] == [1, 1, 1]
    assert len(detections) == 3


def test_a_bottom_that_begins_with_a_step_is_few_echoes() -> None:
    """How many depends on where in a block of the equalizer it begins: none, or up to 8 where half of a block is dark.

    Over these places and six seeds it is 1.8 on average; with columns of one sample it was 3.1.
    """
    column, chain, false = np.arange(2000), Chain(PipelineSettings()), 0
    for first in range(352, 416, 8):
        bias = np.where(column < first, 1.0, 40.0 * np.exp(-(column - first) / 400.0) + 1.0)
        detections = found(bias * (1.0 + body(30.0, 0.1)), 0, chain)
        assert hits(detections, 30.0, 0.1) == 1
        false += len(detections) - 1
    assert false <= 20


def test_weak_specular_objects_are_found_more_often_than_not() -> None:
    """A highlight of a few cells in one beam, 14 dB over the speckle."""
    chain = Chain(PipelineSettings())
    score = 0
    for seed in range(20):
        intensity = np.ones((60, 2000))
        intensity[30, 800:808] += 10.0**1.4
        score += hits(found(intensity, seed, chain), 40.2, float(BEARINGS[30])) > 0
    assert score > 10


def test_nothing_is_found_where_nothing_is() -> None:
    stages = (
        {"use": "equalize.mean_range"},
        {"use": "filter.fir"},
        {"use": "detect.two_level", "levels": "false_alarm", "rate": 1e-9},
    )
    chain = Chain(PipelineSettings(stage=stages))
    assert sum(len(found(np.ones((60, 2000)), seed, chain)) for seed in range(60)) == 0


def test_quay_across_the_whole_sector_is_found() -> None:
    intensity = np.ones((60, 2000))
    for row, bearing in zip(intensity, BEARINGS, strict=True):
        column = round(30.0 / np.cos(bearing) / 0.05)
        row[column : column + 12] += 200.0
    wall = max(found(intensity), key=lambda detection: detection.cells)
    assert wall.bearing_extent_rad > 0.8 * np.pi / 2.0
    ring = np.ones((60, 2000))
    ring[:, 600:612] += 200.0  # at one range everywhere: the worst for an equalizer
    assert max(found(ring), key=lambda detection: detection.cells).bearing_extent_rad > 0.8 * np.pi / 2.0


@pytest.mark.parametrize("bearing", [float(BEARINGS[0]), float(BEARINGS[-1])])
def test_object_at_the_sector_s_edge_is_found_and_its_place_is_uncertain(bearing: float) -> None:
    inside = found(1.0 + body(40.0, 0.1))[0]
    edge = [d for d in found(1.0 + body(40.0, bearing)) if abs(d.range_m - 40.0) < 2.0]
    assert len(edge) == 1
    assert abs(edge[0].bearing_rad - bearing) < 0.05
    assert edge[0].sigma_bearing_rad > 5.0 * inside.sigma_bearing_rad


@pytest.mark.parametrize("range_m", [2.0, 98.0])
def test_objects_at_the_range_ends_are_found(range_m: float) -> None:
    assert hits(found(1.0 + body(range_m, 0.1, 0.8 if range_m < 5.0 else 1.5)), range_m, 0.1) >= 1


def test_two_objects_closer_than_the_beam_are_one_echo_that_holds_both() -> None:
    intensity = 1.0 + body(80.0, 0.100, 0.5) + body(80.0, 0.115, 0.5)  # 1.2 m apart, a beam is 2.1 m wide
    detections = found(intensity)
    assert len(detections) == 1
    assert detections[0].range_m == pytest.approx(80.0, abs=1.0)
    assert detections[0].bearing_rad == pytest.approx(0.1075, abs=0.013)


def test_speckle_alone_is_an_echo_in_one_image_of_ten_at_most() -> None:
    chain = Chain(PipelineSettings())
    assert sum(len(found(np.ones((60, 2000)), seed, chain)) for seed in range(60)) <= 6


@pytest.mark.parametrize("beams", [128, 256])
def test_speckle_at_the_border_of_fine_beams_is_no_more_often_an_echo_than_inside(beams: int) -> None:
    """Two beams on each side: filters mirror the image there, and equalizers know one side only."""
    width = (1.5 * beams / 128.0, 0.8)
    border = total = 0
    *filters, detector = DEFAULT_STAGES
    chain = Chain(PipelineSettings(stage=(*filters, {**detector, "follow": 0.0})))  # or there are too few to compare
    for seed in range(60):
        rng = np.random.default_rng([beams, seed])
        parts = [gaussian_filter(rng.normal(size=(beams, 500)), width, mode="wrap") for _ in range(2)]
        counts = np.rint(150.0 + 30.0 * np.log10(parts[0] ** 2 + parts[1] ** 2)).clip(0, 255).astype(np.uint8)
        bearings = fan_bearings(beams, 30.0)
        ping = make_ping(counts, scale="log8", scale_factor=40.0, bearing_rad=bearings.tolist(), dr_m=0.01)
        places = np.array([d.bearing_rad for d in chain.process(ping).detections])
        border += int(np.sum((places < bearings[1]) | (places > bearings[-2])))
        total += len(places)
    assert total >= 20
    assert border <= 0.1 * total


EQUALIZERS = sorted(name for name in BUILT_IN if name.startswith("equalize."))


@pytest.mark.parametrize("name", EQUALIZERS)
def test_no_equalizer_makes_nan_of_zero_or_saturated_rows(name: str) -> None:
    """Beams and ranges that are zero or saturated, whole images of them, and the pings after those."""
    rng = np.random.default_rng(4)
    good = rng.rayleigh(1.0, (60, 700)).astype(np.float32)
    ill = good.copy()
    ill[7], ill[8], ill[:, 300:310], ill[:, 400:410] = 0.0, 1e6, 0.0, 1e6
    run = stage_on_images(name, Fan(BEARINGS, np.full(60, 0.02), 700, 0.0, 0.05))
    with np.errstate(all="raise"):
        for image in (ill, np.zeros_like(good), np.full_like(good, 1e6), ill, good):
            out = run(image)
            assert np.isfinite(out).all()
            assert out.min() >= 0.0
            assert not out[image == 0.0].any()


@pytest.mark.parametrize("name", EQUALIZERS)
def test_ping_with_nan_is_refused_and_leaves_nothing_behind(name: str) -> None:
    chain = Chain(PipelineSettings(stage=({"use": name}, {"use": "filter.fir"}, {"use": "detect.two_level"})))
    image = (1.0 + 9.0 * np.sqrt(body(40.0, 0.1))).astype(np.float32)
    image *= np.random.default_rng(2).rayleigh(1.0, image.shape).astype(np.float32)
    before = chain.process(make_ping(image)).detections
    ill = image.copy()
    ill[3, 500] = np.nan
    with pytest.raises(PingError, match="not finite"):
        chain.process(make_ping(ill))
    after = chain.process(make_ping(image)).detections
    assert hits(before, 40.0, 0.1) == hits(after, 40.0, 0.1) == 1


@pytest.mark.parametrize("name", EQUALIZERS)
def test_wall_does_not_erase_itself_in_any_equalizer(name: str) -> None:
    """A quay at one range across the whole sector, 20 dB over the speckle, at the first ping and after forty."""
    chain = Chain(PipelineSettings(stage=({"use": name}, {"use": "filter.fir"}, {"use": "detect.two_level"})))
    intensity = np.ones((60, 2000))
    intensity[:, 600:612] += 100.0
    for seed in range(40):
        assert max(d.bearing_extent_rad for d in found(intensity, seed, chain)) > 0.8 * np.pi / 2.0


def squares(best: Detection, range_m: float, bearing: float, radius: float) -> Floats:
    """Squared errors of range, bearing and radius, over the echo's own variances."""
    error = (best.range_m - range_m, best.bearing_rad - bearing, best.radius_m - radius)
    return np.square(np.divide(error, (best.sigma_range_m, best.sigma_bearing_rad, best.sigma_radius_m)))


@pytest.mark.parametrize(("follow", "least"), [(0.0, 0.55), (0.75, 0.35)])
def test_errors_are_as_large_as_the_standard_deviations_say(follow: float, least: float) -> None:
    """Normalised squared errors within the tracker's gate average to 1 a coordinate, half of them those of ideal bodies
    that shine all over, half of them those of the simulator's spheres, of which weak ones show a highlight only.

    They were fitted to all echoes that one pair of levels an image finds. Where levels follow the background, those
    with the largest errors are not found, so that standard deviations are too large; never too small.
    """
    rng = np.random.default_rng(71)
    *filters, detector = DEFAULT_STAGES
    chain = Chain(PipelineSettings(stage=(*filters, {**detector, "follow": follow})))
    ideal, spheres = [], []
    for k in range(80):
        radius, range_m = float(np.exp(rng.uniform(*np.log((0.4, 5.0))))), rng.uniform(12.0, 85.0)
        bearing, snr_db = rng.uniform(-0.5, 0.5), rng.uniform(8.0, 22.0)
        near = found(1.0 + body(range_m, bearing, radius, snr_db), k, chain)
        near = [d for d in near if np.hypot(d.range_m - range_m, range_m * (d.bearing_rad - bearing)) < radius + 2.0]
        if near:
            ideal.append(squares(max(near, key=lambda d: d.cells), range_m, bearing, radius))
    for image in sea_images(40, 72):
        detections = chain.process(image.ping).detections
        for target in image.targets:
            inside = [
                d
                for d in detections
                if target.range_m[0] <= d.range_m <= target.range_m[1]
                and target.bearing_rad[0] <= d.bearing_rad <= target.bearing_rad[1]
            ]
            if target.counts and target.circle is not None and inside:
                spheres.append(squares(max(inside, key=lambda d: d.cells), *target.circle))
    means = [np.where(np.array(part) < GATE**2, part, np.nan) for part in (ideal, spheres)]
    mean = 0.5 * (np.nanmean(means[0], axis=0) + np.nanmean(means[1], axis=0))
    assert len(spheres) > 40
    assert ((least < mean) & (mean < 1.45)).all()
    assert mean.sum() < 3.9
    assert follow or mean.sum() > 2.1
