"""The near edge of echoes, and what tells a body from its front, on echoes made by quadrature and on images by hand."""

import msgspec
import numpy as np
import pytest

from benchmarks.circles import synthetic as circles
from ods.base.arrays import Floats, Floats32, Ints
from ods.messages import Detection
from ods.pipeline.chain import Chain
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import RUN, Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.measure.echoes import measure_echoes
from ods.pipeline.settings import PipelineSettings

BEAMS, COLUMNS, RANGE0_M, DR_M = 9, 400, 40.0, 0.05
NOISE = 1.0


@pytest.fixture(scope="module")
def chain() -> Chain:
    return Chain(PipelineSettings())


def found(chain: Chain, kind: str, size: float, range_m: float, snr_db: float) -> list[Detection]:
    """Return what is found of a body on the fan's axis, in 16 images of other speckle."""
    rng = np.random.default_rng([int(range_m), int(snr_db)])
    mean = 1.0 + 10.0 ** (0.1 * snr_db) * circles.mean_intensity(circles.body(kind, size), range_m, 0.01)
    seen = []
    for _ in range(16):
        detections = chain.process(circles.ping_of(30.0 * np.sqrt(mean * rng.exponential(size=mean.shape)))).detections
        near = [d for d in detections if abs(d.range_m - range_m) < 4.0 and abs(d.bearing_rad - 0.01) * range_m < 4.0]
        seen += [max(near, key=lambda d: d.snr_db)] if near else []
    assert len(seen) >= 12
    return seen


@pytest.mark.parametrize("range_m", [20.0, 50.0, 90.0])
@pytest.mark.parametrize(
    ("kind", "size", "snr_db"),
    [("front", 1.5, 12.0), ("front", 3.0, 25.0), ("disc", 1.5, 10.0), ("disc", 3.0, 20.0), ("plate", 1.5, 25.0),
     ("plate", 3.0, 20.0), ("point", 0.0, 25.0)],
)  # fmt: skip
def test_near_edge_is_where_the_body_begins(
    chain: Chain, kind: str, size: float, snr_db: float, range_m: float
) -> None:
    near = range_m - (size if kind in ("front", "disc") else 0.0)
    echoes = found(chain, kind, size, range_m, snr_db)
    error = np.array([d.near_m - near for d in echoes])
    claimed = np.array([d.sigma_near_m for d in echoes])
    assert abs(np.median(error)) < 0.15
    assert abs(error.mean()) < 0.15 + circles.SONAR.dr_m
    assert np.median((error / claimed) ** 2) < 3.0  # 0.45 of a normal error
    assert claimed.max() < 0.8


def test_a_disc_is_its_circle_and_a_front_is_behind_what_shines(chain: Chain) -> None:
    for range_m in (20.0, 90.0):
        for kind, slack in (("disc", 0.2), ("front", 0.5)):
            echoes = found(chain, kind, 1.5, range_m, 20.0)
            assert abs(np.mean([d.radius_m for d in echoes]) - 1.5) < slack
            assert abs(np.mean([d.range_m for d in echoes]) - range_m) < slack


FAN = Fan(np.radians(1.5) * (np.arange(BEAMS) - 4.0), np.full(BEAMS, np.radians(1.5)), COLUMNS, RANGE0_M, DR_M)


def measured(image: Floats32, first: Ints, stop: Ints, fan: Fan = FAN) -> Detection:
    """Return the echo of a region of columns `first` to `stop` - 1 of each beam, where there are any."""
    runs = [(b, first[b], stop[b], 1) for b in range(BEAMS) if stop[b] > first[b]]
    recorded = Recorded(np.zeros(image.shape, np.uint16), np.arange(COLUMNS), 1)
    return Detection(*measure_echoes(image, Regions(np.array(runs, RUN), 1, NOISE), recorded, fan)[0].tolist())


def smoothed(rows: Floats, sigma: float) -> Floats32:
    offset = np.arange(-30, 31)
    weights = np.exp(-0.5 * (offset / sigma) ** 2)
    out = np.array([np.convolve(row, weights / weights.sum(), "same") for row in rows])
    out[:, :40], out[:, -40:] = NOISE, NOISE  # the convolution's own ends
    return out.astype(np.float32)


@pytest.mark.parametrize("sigma", [1.0, 2.5, 5.0])
def test_a_symmetric_filter_leaves_the_edge_of_a_step_and_the_place_of_a_point(sigma: float) -> None:
    step = np.full((BEAMS, COLUMNS), 0.0)
    step[3:6, 150:260] = 40.0
    point = np.full((BEAMS, COLUMNS), 0.0)
    point[4, 150] = 400.0
    for rows, where in ((step, 149.5), (point, 150.0)):
        image = np.maximum(smoothed(rows, sigma), np.float32(NOISE))
        above = image > 2.0
        first = np.where(above.any(1), above.argmax(1), 0)
        stop = np.where(above.any(1), COLUMNS - above[:, ::-1].argmax(1), 0)
        echo = measured(image, first, stop)
        assert abs(echo.near_m - (RANGE0_M + DR_M * where)) < 0.8 * DR_M


def test_a_fragment_of_a_weak_body_begins_where_its_level_does() -> None:
    rng = np.random.default_rng(3)
    for begin in (100, 140, 190):
        image = smoothed(np.sqrt(rng.exponential(size=(BEAMS, COLUMNS))), 2.0) / np.sqrt(np.pi / 4.0)
        image[2:7, begin:260] *= 2.0
        first, stop = np.zeros(BEAMS, np.int64), np.zeros(BEAMS, np.int64)
        first[2:7], stop[2:7] = 200, 250  # what the detector found
        echo = measured(image.astype(np.float32), first, stop)
        assert abs(echo.near_m - (RANGE0_M + DR_M * begin)) < 0.3
        assert echo.sigma_near_m > 0.2


def test_a_fragment_deep_inside_a_weak_body_may_look_like_a_front() -> None:
    rng = np.random.default_rng(4)
    for begin in (100, 140, 170):
        image = smoothed(np.sqrt(rng.exponential(size=(BEAMS, COLUMNS))), 2.0) / np.sqrt(np.pi / 4.0)
        image[2:7, begin:300] *= 2.0
        image[2:7, 200:230] *= np.linspace(1.7, 0.8, 30)  # it pales behind its crest
        first, stop = np.zeros(BEAMS, np.int64), np.zeros(BEAMS, np.int64)
        first[2:7], stop[2:7] = 200, 230
        echo = measured(image.astype(np.float32), first, stop)
        assert abs(echo.near_m - (RANGE0_M + DR_M * begin)) < 0.3


def test_the_near_edge_of_a_weak_disc_in_fragments(chain: Chain) -> None:
    """Discs of 9 m of 6 dB: without a search the loudest fragment began 2.4 m too far, rms, as seen by the chain."""
    rng, case = np.random.default_rng([5, 35]), circles.Case("disc", 4.5, 35.0, 6.0)
    error = circles.errors_of(list(circles.looks(chain, case, 30, rng))).wrong[:, 0]
    assert len(error) > 15
    assert np.sqrt((error**2).mean()) < 1.0


def test_the_circle_of_a_round_echo_begins_at_the_near_edge() -> None:
    image = np.full((BEAMS, COLUMNS), NOISE, np.float32)
    first, stop = np.zeros(BEAMS, np.int64), np.zeros(BEAMS, np.int64)
    image[4, 200:260] = 8.0 * np.exp(-np.arange(60) / 20.0)  # it pales behind its front
    first[4], stop[4] = 200, 240
    echo = measured(image, first, stop)
    assert echo.range_m - echo.radius_m == pytest.approx(echo.near_m)
    assert echo.radius_m > 0.5  # half the level is left 0.7 m behind the edge: of a body that would be its diameter


def test_the_centre_of_a_small_body_is_the_middle_of_what_shines() -> None:
    image = np.full((BEAMS, COLUMNS), NOISE, np.float32)
    first, stop = np.zeros(BEAMS, np.int64), np.zeros(BEAMS, np.int64)
    for beam, begin in enumerate((205, 201, 200, 201, 205), 2):  # its front is round, and pales behind its crest
        image[beam, begin:216] = 8.0 * np.exp(-np.arange(216 - begin) / 6.0)
        first[beam], stop[beam] = begin, 210
    fan = Fan(np.radians(0.3) * (np.arange(BEAMS) - 4.0), np.full(BEAMS, np.radians(0.3)), COLUMNS, 6.0, 0.01)
    echo = measured(image, first, stop, fan)
    assert 8.0 < echo.range_m < 8.1


def test_a_recording_of_before_tells_no_near_edge() -> None:
    since = ("near_m", "sigma_near_m", "cut", "onset")
    old = {name: 1.0 for name in Detection.__struct_fields__ if name not in since} | {"cells": 1}
    echo = msgspec.msgpack.decode(msgspec.msgpack.encode(old), type=Detection)
    assert (echo.near_m, echo.sigma_near_m) == (0.0, 0.0)
