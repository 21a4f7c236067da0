"""Where the bottom's echo sets in: against made-up profiles in closed form, the simulator's beds, and real frames."""

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.messages import BottomEcho, Ping, SampleType, Scale
from ods.pipeline.bottom_echo import EDGE_OF_HALF
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.sonar_link.files.opening import open_pings

DATA = Path(__file__).parents[1] / "data"
BEAMS, SAMPLES, DR = 60, 1000, 0.1
RANGE = DR * (np.arange(SAMPLES) + 1.0)
BEARING = np.radians(np.linspace(-44.25, 44.25, BEAMS))
HALF_DEG = 10.0
SHALLOW = 1.08
"""Where in half openings a level 4 dB under the bottom's is heard, with the pattern below."""


def level_db(height_m: float, side_lobe_db: float = -20.0) -> Floats:
    """Level over range of a bottom so far below a level sonar: main lobe, null, side lobe; as loud at all ranges."""
    angle = np.degrees(np.arcsin(np.minimum(height_m / RANGE, 1.0)))
    lobes = np.interp(
        angle, [0.0, 5.0, 10.0, 12.0, 14.0, 20.0, 60.0, 89.9], [0, 0, -2.5, -10, -30, side_lobe_db, -25, -60]
    )
    return np.where(height_m < RANGE, lobes, -60.0)


def ping_of(mean_db: Floats, dtype: SampleType = "u2", scale: Scale = "linear", seed: int = 0) -> Ping:
    """Return speckle of a mean level, dB over what is loudest, (samples,) or (beams, samples), over noise at -24 dB."""
    power = 10.0 ** (np.broadcast_to(mean_db, (BEAMS, SAMPLES)) / 10.0) + 10.0**-2.4
    amplitude = 2000.0 * np.sqrt(power * np.random.default_rng(seed).exponential(1.0, power.shape))
    factor = 1.0
    if scale == "log8":
        factor = 60.0
        amplitude = factor * np.log10(amplitude + 1.0)
    counts = np.round(amplitude).astype({"u1": "u1", "u2": "<u2", "f4": "<f4"}[dtype])
    return Ping(
        0, 0, 0, 0, 0, BEAMS, SAMPLES, dtype, counts.tobytes(), BEARING.tolist(), float(RANGE[0]), DR, 1500.0,
        scale=scale, scale_factor=factor,
    )  # fmt: skip


def found(ping: Ping, *, wanted: bool = True) -> BottomEcho | None:
    return Chain(PipelineSettings(vertical_half_deg=HALF_DEG, bottom_echo=wanted)).process(ping).bottom_echo


@pytest.mark.parametrize("height_m", [2.0, 3.5, 6.0, 9.0])
@pytest.mark.parametrize(("dtype", "scale"), [("u1", "log8"), ("u2", "linear"), ("f4", "linear")])
def test_its_range_is_that_of_the_patterns_side(height_m: float, dtype: SampleType, scale: Scale) -> None:
    echo = found(ping_of(level_db(height_m), dtype, scale))
    assert echo is not None
    assert len(echo.range_m) == len(echo.bearing_rad) >= 7
    assert echo.below_rad == pytest.approx(math.radians(HALF_DEG * EDGE_OF_HALF))
    wanted = height_m / math.sin(math.radians(SHALLOW * HALF_DEG))
    assert np.median(echo.range_m) == pytest.approx(wanted, rel=0.04)
    assert max(echo.range_m) / min(echo.range_m) < 1.25


@pytest.mark.parametrize(
    "mean_db",
    [
        np.full(SAMPLES, -60.0),
        np.full(SAMPLES, 0.0),
        level_db(9.0, side_lobe_db=-60.0),  # no side lobe: it may be that of a bottom far below
        level_db(30.0),  # main lobe meets it beyond the range
        np.where(np.abs(RANGE - 40.0) < 1.5, 0.0, -60.0),  # a wall, and its shadow
        np.where((BEARING > 0.1)[:, None] & (RANGE > 30.0), 0.0, -60.0),  # a bank on one side
        np.minimum(30.0 * np.log10(RANGE / 100.0), 0.0),  # noise under a gain that grows
    ],
    ids=["noise", "reverberation", "no side lobe", "deep", "wall", "bank", "gain"],
)
def test_what_is_no_bottom_below(mean_db: Floats) -> None:
    for seed in range(3):
        assert found(ping_of(mean_db, seed=seed)) is None


def test_bodies_before_a_bottom_and_dead_beams_do_not_move_it() -> None:
    mean = np.tile(level_db(5.0), (BEAMS, 1))
    mean[20:24, 150:180] = 10.0
    mean[40:42, 300:380] = 10.0
    ping = ping_of(mean)
    samples = np.frombuffer(ping.data, "<u2").reshape(BEAMS, SAMPLES).copy()
    samples[5:9], samples[50:52, 400:] = 0, 0
    echo = found(msgspec.structs.replace(ping, data=samples.tobytes()))
    assert echo is not None
    assert np.median(echo.range_m) == pytest.approx(5.0 / math.sin(math.radians(SHALLOW * HALF_DEG)), rel=0.04)


def test_data_that_begin_late_are_no_rise() -> None:
    ping = ping_of(np.full(SAMPLES, 0.0))
    gone = [(beam, 0, 300) for beam in range(BEAMS)]
    samples = np.frombuffer(ping.data, "<u2").reshape(BEAMS, SAMPLES).copy()
    samples[:, :300] = 0
    assert found(msgspec.structs.replace(ping, data=samples.tobytes(), no_data=gone)) is None
    assert found(msgspec.structs.replace(ping, data=samples.tobytes())) is None


def test_the_lowest_of_three_planes_is_looked_at() -> None:
    one = ping_of(level_db(6.0))
    noise = ping_of(np.full(SAMPLES, -60.0))
    elevation = [0.2] * BEAMS + [-0.1] * BEAMS + [0.05] * BEAMS
    three = msgspec.structs.replace(
        one, beams=3 * BEAMS, planes=3, data=noise.data + one.data + noise.data, bearing_rad=3 * one.bearing_rad,
        elevation_rad=elevation,
    )  # fmt: skip
    echo, alone = found(three), found(one)
    assert echo is not None
    assert alone is not None
    assert echo.range_m == alone.range_m
    assert echo.below_rad == pytest.approx(alone.below_rad + 0.1)


def test_it_is_looked_for_at_each_fourth_ping_if_at_all() -> None:
    ping, chain = ping_of(level_db(5.0)), Chain(PipelineSettings())
    assert found(ping, wanted=False) is None
    told = [chain.process(msgspec.structs.replace(ping, seq=seq)).bottom_echo is not None for seq in range(9)]
    assert told == [True, False, False, False, True, False, False, False, True]


@pytest.mark.parametrize("file", ["aris/sample.aris", "oculus/three_pings_8bit.raw"])
def test_real_frames_without_one(file: str) -> None:
    """Both look along a floor from near above it, through windows of range in which no lobe begins."""
    chain = Chain(PipelineSettings())
    for ping in list(open_pings(DATA / file, None).pings)[:3]:
        assert chain.process(msgspec.structs.replace(ping, seq=0)).bottom_echo is None


def test_a_simulated_bed_of_rocks() -> None:
    """Its profile is the simulator's, with another pattern and a level that falls with the grazing angle."""
    told = {
        "seed": 3,
        "vehicle": {"position_ned": [0.0, 0.0, 20.0]},
        "sea_bed": {"depth_m": 24.0, "rough": {"rms_height_m": 0.15, "correlation_m": 2.0}},
    }
    images = ImageSimulator(find_sonar("seabat6012"), Scene(msgspec.convert(told, SceneFile)))
    echo = found(images.ping(0.0, 0, 0, 0))
    assert echo is not None
    assert np.median(echo.range_m) * math.sin(echo.below_rad) == pytest.approx(4.0, rel=0.25)
