import math
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.optimize import brentq

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.base.settings_file import ConfigError
from ods.messages import frame_of
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.pose import Transmission, VehiclePose
from ods.sim_sonar.receiver.quantize import LogQuantizer, PingMaker, quantize_linear
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.receiver.signal_chain import Receiver
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.sonar.model import SonarModel, load_sonar, make_sonar
from ods.sim_sonar.sonar.settings import SonarFile
from ods.sonar_link.s7k import records, water_column
from ods.sonar_link.s7k.framer import RecordFramer

SEABAT = load_sonar(Path(__file__).parents[2] / "config/sonars/seabat6012.toml")
RANGES = 0.05 * (1 + np.arange(2000))
HERE = np.zeros(3)
AHEAD = np.array([1.0, 0.0, 0.0, 0.0])


def levels_of(**image: object) -> ImageLevels:
    return msgspec.convert({"gain": 1000.0, "noise_counts": 0.0, **image}, ImageLevels)


def sent(ping: int = 0) -> Transmission:
    return Transmission(VehiclePose(HERE, AHEAD), ping_number=ping)


def mean_db(ping: int = 0, t_s: float = 0.0, area: float = 1.0, attitude: Floats = AHEAD, **image: object) -> Floats:
    """Return the level of each sample of an even image, dB over its level without imperfections."""
    levels = levels_of(speckle=False, **image)
    received = Receiver(SEABAT, levels, 4).receive(
        np.full((60, 2000), area), Transmission(VehiclePose(HERE, attitude), t_s, ping)
    )
    reference = max(area * levels.gain**2, levels.noise_counts**2 if not area else 0.0) or 1.0
    return np.asarray(20.0 * np.log10(np.maximum(received.astype(np.float64), 1e-6)) - 10.0 * np.log10(reference))


# --- gain


def test_tvg_set_right_undoes_spreading_and_absorption_exactly() -> None:
    assert not mean_db().any()
    said = {"spreading_db": 33.0, "absorption_db_per_m": 0.4}
    assert not mean_db(tvg=said).any()
    assert not mean_db(tvg={**said, "set_spreading_db": 33.0, "set_absorption_db_per_m": 0.4}).any()


def test_tvg_set_wrong_leaves_the_difference() -> None:
    tvg = {"spreading_db": 40.0, "absorption_db_per_m": 0.12, "set_spreading_db": 30.0, "set_absorption_db_per_m": 0.1}
    expected = -10.0 * np.log10(RANGES) - 0.04 * RANGES
    np.testing.assert_allclose(mean_db(tvg=tvg), np.tile(expected, (60, 1)), atol=1e-4)


def test_tvg_lifts_the_noise() -> None:
    noise = mean_db(area=0.0, noise_counts=20.0, tvg={"noise_range_m": 50.0, "absorption_db_per_m": 0.1})
    expected = 40.0 * np.log10(RANGES / 50.0) + 0.2 * (RANGES - 50.0)
    shown = expected > -60.0
    np.testing.assert_allclose(noise[3][shown], expected[shown], atol=1e-3)
    assert not mean_db(area=0.0, noise_counts=20.0).any()


def test_belts_are_where_asked() -> None:
    belts = [
        {"from_m": 50.0, "to_m": 60.0, "gain_db": -6.0, "edge_m": 2.0},
        {"from_m": 70.0, "to_m": 80.0, "gain_db": 4.0},
    ]
    level = mean_db(belts=belts)
    assert np.ptp(level, axis=0).max() == 0.0
    at = {metres: level[0, round(metres / 0.05) - 1] for metres in (45, 48.9, 50, 51.1, 55, 60, 65, 75, 85)}
    expected = {45: 0, 48.9: 0, 50: -3, 51.1: -6, 55: -6, 60: -3, 65: 0, 75: 4, 85: 0}
    assert at == pytest.approx(expected, abs=0.01)


def test_beam_gains() -> None:
    given_db = [0.1 * beam for beam in range(60)]
    np.testing.assert_allclose(mean_db(beam_gain_db=given_db)[:, 7], given_db, atol=1e-4)
    drawn = mean_db(beam_gain_rms_db=2.0)
    assert np.ptp(drawn, axis=1).max() == 0.0
    assert drawn[:, 0].std() == pytest.approx(2.0, rel=0.3)
    np.testing.assert_array_equal(drawn, mean_db(ping=9, t_s=3.0, beam_gain_rms_db=2.0))


def test_drop_outs_and_drop_ins_are_where_and_when_asked() -> None:
    arcs: dict[str, Any] = {
        "dropouts": [
            {"range_m": 78.0, "width_m": 0.42},
            {"range_m": 20.0, "width_m": 0.52, "gain_db": -10.0, "pings": [3, 5]},
        ],
        "drop_ins": [{"range_m": 82.0, "width_m": 1.02, "gain_db": 12.0}],
    }
    for ping in range(6):
        level = mean_db(ping=ping, **arcs)[11]
        expected = np.zeros(2000)
        expected[np.abs(RANGES - 78.0) < 0.21] = -20.0
        expected[np.abs(RANGES - 82.0) < 0.51] = 12.0
        if ping in (3, 5):
            expected[np.abs(RANGES - 20.0) < 0.26] = -10.0
        np.testing.assert_allclose(level, expected, atol=1e-3)


def test_random_drop_outs_come_as_often_as_asked_and_anywhere() -> None:
    receiver = Receiver(SEABAT, levels_of(dropouts=[{"chance": 0.3, "width_m": 1.0}]), 8)
    dark = [receiver.levels_of(sent(ping)).over_range < 0.5 for ping in range(1000)]
    middles = [RANGES[row].mean() for row in dark if row.any()]
    assert len(middles) == pytest.approx(300, abs=45)
    assert np.histogram(middles, 4, (0.0, 100.0))[0] == pytest.approx(75.0, abs=30)


def test_a_wide_drop_out_takes_the_whole_image() -> None:
    lost = mean_db(ping=2, dropouts=[{"range_m": 50.0, "width_m": 200.0, "gain_db": -40.0, "pings": [2]}])
    np.testing.assert_allclose(lost, -40.0, atol=1e-3)


def test_saturation() -> None:
    area = np.tile(np.linspace(0.0, 4.0, 2000), (60, 1))
    image = Receiver(SEABAT, levels_of(speckle=False, saturation_counts=1500.0), 1).receive(area, sent())
    np.testing.assert_allclose(image, np.minimum(1000.0 * np.sqrt(area), 1500.0), rtol=1e-5)
    speckled = Receiver(SEABAT, levels_of(saturation_counts=1500.0), 1).receive(area, sent())
    assert speckled.max() == 1500.0


# --- other sonars


def other(**more: float) -> list[dict[str, object]]:
    beam = SEABAT.bearing_rad[40]
    place = [80.0 * math.cos(beam), 80.0 * math.sin(beam), 3.0]
    return [{"position_ned": place, "level_counts": 500.0, **more}]


def test_a_source_without_end_is_a_spoke() -> None:
    level = 10.0 ** (mean_db(area=0.0, interference=other()) / 20.0)
    np.testing.assert_allclose(level[40], 500.0, rtol=1e-3)
    assert np.argmax(level[:, 0]) == 40
    assert 20.0 * math.log10(level[20, 0] / 500.0) < -25.0
    assert np.ptp(level, axis=1).max() < 1e-3
    turned = 10.0 ** (mean_db(area=0.0, attitude=geometry.quat_from_euler(0.0, 0.0, 10 * SEABAT.beam_width_rad),
                              interference=other()) / 20.0)  # fmt: skip
    assert np.argmax(turned[:, 0]) == 30


def array_pattern(offset: Floats) -> Floats:
    """Return the power, offsets in beam widths, that a line array with a Kaiser-Bessel taper of -25 dB side lobes has
    from afar: a sum over its elements."""
    elements = (np.arange(2000) + 0.5) / 1000.0 - 1.0
    taper = brentq(lambda b: 20.0 * math.log10(math.sinh(b) / b) + 13.26 - 25.0, 0.1, 10.0)
    weight = np.i0(taper * np.sqrt(1.0 - elements**2)) / np.i0(taper * np.sqrt(1.0 - elements**2)).sum()
    half = brentq(lambda u: float(np.cos(u * elements) @ weight) - math.sqrt(0.5), 0.1, 3.0)
    return np.asarray(np.cos(np.multiply.outer(2.0 * half * offset, elements)) @ weight) ** 2


@pytest.mark.parametrize("turn", [-0.4, 0.13, 0.3])
def test_beams_hear_a_source_by_their_pattern(turn: float) -> None:
    attitude = geometry.quat_from_euler(0.0, 0.0, turn * SEABAT.beam_width_rad)
    reported = mean_db(area=0.0, attitude=attitude, interference=other())[:, 0]
    expected = array_pattern(np.arange(-40.0, 20.0) + turn)
    np.testing.assert_allclose(10.0 ** (reported / 10.0) / 500.0**2, expected, rtol=1e-2, atol=3e-5)


def test_pulses_walk_through_the_images_at_their_own_rate() -> None:
    sources = other(period_s=0.11, pulse_s=0.001, start_s=0.02)
    for ping in range(8):
        t_s = ping * SEABAT.ping_period_s
        power = 100.0 ** (mean_db(ping, t_s, 0.0, interference=sources)[40] / 20.0) / 500.0**2
        arrival_s = t_s + 2.0 * RANGES / 1500.0
        expected = (arrival_s - 0.02) % 0.11 < 0.001
        assert power.sum() == pytest.approx(expected.sum(), abs=1.1)
        sure = np.convolve(expected, np.ones(3), "same")
        np.testing.assert_allclose(power[sure == 3], 1.0, rtol=1e-2)
        assert power[sure == 0].max() < 1e-6


def test_interference_is_noise_that_is_fresh_in_each_ping() -> None:
    receiver = Receiver(SEABAT, levels_of(interference=other()), 1)
    empty = np.zeros((60, 2000))
    one, two = (receiver.receive(empty, sent(ping))[40] for ping in (0, 1))
    assert np.square(one).mean() == pytest.approx(500.0**2, rel=0.1)
    assert abs(np.corrcoef(one, two)[0, 1]) < 0.1


def test_a_source_sounds_in_its_time_only() -> None:
    for t_s, audible in ((0.0, False), (2.9, False), (3.0, True), (4.9, True), (5.0, False)):
        level = mean_db(t_s=t_s, area=0.0, interference=other(from_s=3.0, to_s=5.0))[40]
        assert (level.max() > 50.0) == audible


def test_a_loud_spell_is_noise_in_its_beams_for_its_time() -> None:
    spells = [{"level_counts": 300.0, "first_beam": 10, "beams": 5, "from_s": 1.0, "to_s": 2.0}]
    level = mean_db(t_s=1.5, area=0.0, noise_counts=30.0, loud_spells=spells)
    np.testing.assert_allclose(level[10:15], 10.0 * math.log10(101.0), atol=1e-3)
    np.testing.assert_allclose(np.delete(level, range(10, 15), axis=0), 0.0, atol=1e-3)
    assert not mean_db(t_s=2.0, area=0.0, noise_counts=30.0, loud_spells=spells).any()


def test_by_a_second_way_all_comes_once_more() -> None:
    area = np.zeros((60, 2000))
    area[20, 500:510] = 1.0
    levels = levels_of(speckle=False, second_ways=[{"longer_m": 6.0, "gain_db": -12.0}])
    image = Receiver(SEABAT, levels, 1).receive(area, sent())
    expected = 1000.0 * area
    expected[20, 620:630] = 1000.0 * 10.0 ** (-12.0 / 20.0)
    np.testing.assert_allclose(image, expected, rtol=1e-5)


# --- samples


def test_log_samples_follow_record_7042() -> None:
    counts = np.array([[0.0, 0.3, 1.0, 10.0, 1e3, 1e6, 1e12]], np.float32)
    assert LogQuantizer()(counts).tolist() == [[0, 0, 0, 40, 120, 240, 255]]


@settings(deadline=None)  # the first example compiles
@given(st.lists(st.floats(0.0, 1e9, width=32), min_size=1, max_size=50), st.sampled_from([10.0, 40.0, 53.1]))
def test_log_samples_are_the_rounded_logarithm(values: list[float], factor: float) -> None:
    amplitude = np.array(values, np.float32)
    exact = factor * np.log10(np.maximum(amplitude.astype(np.float64), 1.0))
    samples = LogQuantizer(factor)(amplitude).astype(np.float64)
    assert np.all(np.abs(samples - np.minimum(exact, 255.0)) <= 0.5 + 1e-5)


def test_linear_samples() -> None:
    counts = np.array([[0.0, 0.4, 0.6, 100.0, 65535.0, 1e9]], np.float32)
    assert quantize_linear(counts, 65535.0, np.uint16).tolist() == [[0, 0, 1, 100, 65535, 65535]]
    assert quantize_linear(counts * 10, 1000.0, np.uint8).tolist() == [[0, 1, 2, 255, 255, 255]]


@pytest.mark.parametrize(("kind", "dtype", "scale"), [("log8", "u1", "log8"), ("linear8", "u1", "linear")])
def test_ping_carries_its_geometry(kind: str, dtype: str, scale: str) -> None:
    ping = PingMaker(SEABAT, levels_of(samples=kind))(np.full((60, 2000), 100.0, np.float32), 7, 123, 456)
    assert (ping.dtype, ping.scale, ping.ping_number, ping.t_ns, ping.utc_ns) == (dtype, scale, 7, 123, 456)
    assert frame_of(ping).shape == (60, 2000)
    assert np.all(frame_of(ping) == (80 if kind == "log8" else 0))
    assert ping.range0_m == SEABAT.range0_m
    np.testing.assert_allclose(ping.bearing_rad, SEABAT.bearing_rad)


def test_16_bit_samples_go_out_as_record_7018() -> None:
    image = np.random.default_rng(1).uniform(0.0, 70000.0, (60, 2000)).astype(np.float32)
    ping = PingMaker(SEABAT, levels_of(samples="linear16"))(image, 7, 0, 1_577_836_800_000_000_000)
    assert (ping.range0_m, ping.samples, ping.dtype, ping.scale) == (0.0, 2001, "u2", "linear")
    assert not frame_of(ping)[:, 0].any()
    framer = RecordFramer()
    bodies = {record.record_type: record.body for record in framer.feed(records.encode_ping(ping)) + framer.flush()}
    decoded = water_column.decode_7018(bodies[records.BEAMFORMED_DATA])
    np.testing.assert_array_equal(decoded.frame[:, 1:], np.minimum(np.rint(image), 65535))


def test_a_first_range_off_the_grid_stays() -> None:
    sonar = make_sonar(SonarFile(name="x", frequency_hz=1e6, beam_width_deg=1.0, range0_m=0.73, dr_m=0.1, samples=9))
    ping = PingMaker(sonar, levels_of(samples="linear16"))(np.ones((1, 9), np.float32), 0, 0, 0)
    assert (ping.range0_m, ping.samples) == (0.73, 9)


# --- bad files

HEAD = "seed = 1\n[vehicle]\nposition_ned = [0.0, 0.0, 10.0]\n[image]\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("looks = 0.1", "image.looks"),
        ("range_correlation = 1.0", "image.range_correlation"),
        (
            "belts = [{ from_m = 60.0, to_m = 50.0, gain_db = 1.0 }]",
            "image.belts.*to_m: must be greater than from_m, 60",
        ),
        ("dropouts = [{ gain_db = 3.0 }]", r"image.dropouts\[.*gain_db"),
        ("drop_ins = [{ chance = 1.5 }]", r"image.drop_ins\[.*chance"),
        ("dropouts = [{ range = 3.0 }]", r"image.dropouts\[.*range: unknown key"),
        ("interference = [{ level_counts = 3.0 }]", r"image.interference\[.*position_ned: missing"),
        ('samples = "log16"', "image.samples"),
        ("tvg = { spreading_db = nan }", "image.tvg.spreading_db: must be a finite number"),
        ("saturation_counts = 0.0", "image.saturation_counts"),
        ("beam_gain_db = [1.0]\nbeam_gain_rms_db = 1.0", "beam_gain_rms_db: cannot be combined with beam_gain_db"),
    ],
)
def test_bad_keys_are_one_line(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(HEAD + text)
    with pytest.raises(ConfigError, match=said) as caught:
        load_scene(path)
    assert "\n" not in str(caught.value)


def test_beam_gains_must_fit_the_sonar(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(HEAD + "beam_gain_db = [1.0, 2.0]")
    with pytest.raises(ValueError, match=r"image.beam_gain_db: 2 values for the 60 beams of SeaBat 6012"):
        ImageSimulator(SEABAT, load_scene(path))


@pytest.mark.parametrize("sonar", [SEABAT])
def test_no_sample_is_nan(sonar: SonarModel) -> None:
    for area in (0.0, 1e-30, 1e12):
        image = Receiver(sonar, levels_of(), 1).receive(np.full((60, 2000), area), sent())
        assert np.isfinite(image).all()
        assert image.min() >= 0.0
