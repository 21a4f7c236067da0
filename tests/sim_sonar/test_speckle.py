import hashlib
import math
import subprocess
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
from scipy import stats

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.sim_sonar.pose import Transmission, VehiclePose
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.receiver.signal_chain import Receiver
from ods.sim_sonar.receiver.speckle.speckle_law import (
    TABLE_NODES,
    TABLE_REACH,
    beam_overlap_correlation,
    speckle_amplitudes,
    taps,
)
from ods.sim_sonar.sonar.model import SonarModel, load_sonar, make_sonar
from ods.sim_sonar.sonar.settings import SonarFile

pytestmark = pytest.mark.slow

SEABAT_FILE = Path(__file__).parents[2] / "config/sonars/seabat6012.toml"
SEABAT = load_sonar(SEABAT_FILE)
EVEN = np.ones((60, 2000))
GAIN = 100.0
BEAM = SEABAT.beam_width_rad


def sent_from(north: float = 0.0, east: float = 0.0, down: float = 0.0, yaw: float = 0.0,
              t_s: float = 0.0, ping: int = 0) -> Transmission:  # fmt: skip
    pose = VehiclePose(np.array([north, east, down]), geometry.quat_from_euler(0.0, 0.0, yaw))
    return Transmission(pose, t_s, ping)


AT_ORIGIN = sent_from()


def image_of(levels: ImageLevels, sent: Transmission = AT_ORIGIN, seed: int = 5,
             sonar: SonarModel = SEABAT) -> Floats:  # fmt: skip
    area = np.ones((sonar.beams, sonar.samples))
    return Receiver(sonar, levels, seed).receive(area, sent).astype(np.float64)


def plain(looks: float = 1.0, **more: float) -> ImageLevels:
    said = {"gain": GAIN, "noise_counts": 0.0, "looks": looks, "beam_correlation": 0.0, **more}
    return msgspec.convert(said, ImageLevels)


def correlation(one: Floats, other: Floats) -> float:
    return float(np.corrcoef(one.ravel(), other.ravel())[0, 1])


def from_sample_to_sample(image: Floats) -> float:
    return correlation(image[:, 1:], image[:, :-1])


def from_beam_to_beam(image: Floats) -> float:
    return correlation(image[1:], image[:-1])


# --- one image


@pytest.mark.parametrize("looks", [0.7, 1.0, 1.2, 4.0])
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_intensity_follows_the_gamma_law(looks: float, noise: float) -> None:
    image = image_of(plain(looks, noise_counts=noise * GAIN))
    intensity = np.square(image) / (GAIN**2 * (1.0 + noise**2))
    assert intensity.mean() == pytest.approx(1.0, abs=0.02)
    assert intensity.var() == pytest.approx(1.0 / looks, rel=0.05)
    assert stats.kstest(intensity.ravel()[::7], stats.gamma(looks, scale=1.0 / looks).cdf).pvalue > 0.001


def test_rare_peaks_are_as_rare_as_they_should_be() -> None:
    receiver = Receiver(SEABAT, plain(), 3)
    found = np.zeros(3)
    for k in range(40):
        image = receiver.receive(EVEN, sent_from(50.0 * k, ping=k))
        found += [np.count_nonzero(image > GAIN * np.sqrt(level)) for level in (7.0, 9.0, 11.0)]
    np.testing.assert_allclose(found, 4.8e6 * np.exp([-7.0, -9.0, -11.0]), rtol=0.25)


@pytest.mark.parametrize("looks", [1.0, 3.0])
@pytest.mark.parametrize(("along", "across"), [(0.0, 0.0), (0.16, 0.03), (0.5, 0.78), (0.9, 0.3)])
def test_neighbours_are_correlated_as_asked(looks: float, along: float, across: float) -> None:
    image = image_of(plain(looks, range_correlation=along, beam_correlation=across))
    assert from_sample_to_sample(image) == pytest.approx(along, abs=0.02)
    assert from_beam_to_beam(image) == pytest.approx(across, abs=0.03)
    assert np.square(image).mean() / GAIN**2 == pytest.approx(1.0, abs=0.06)


def test_beams_that_overlap_share_their_speckle() -> None:
    def correlation_of(spacing_deg: float) -> float:
        sonar = make_sonar(SonarFile(name="x", frequency_hz=4e5, beams_per_plane=60, beam_spacing_deg=spacing_deg,
                                     beam_width_deg=1.0, range0_m=0.1, dr_m=0.1, samples=2000))  # fmt: skip
        levels = ImageLevels(gain=GAIN, noise_counts=0.0)
        assert 0.0 <= beam_overlap_correlation(sonar, 1.0) < 1.0
        image = image_of(levels, sonar=sonar)
        return from_beam_to_beam(np.square(image))

    # a Gaussian beam of this width has intensities correlated by exp(-2 ln 2 (spacing / width)^2)
    for spacing in (0.5, 1.0):
        assert correlation_of(spacing) == pytest.approx(np.exp(-2.0 * np.log(2.0) * spacing**2), abs=0.06)
    assert correlation_of(2.0) < 0.03


def test_planes_do_not_share_speckle() -> None:
    sonar = make_sonar(SonarFile(name="x", frequency_hz=4e5, beams_per_plane=20, beam_width_deg=1.0, range0_m=0.1,
                                 dr_m=0.1, samples=2000, plane_elevation_deg=[-10.0, 0.0, 10.0]))  # fmt: skip
    image = image_of(plain(beam_correlation=0.7), sonar=sonar).reshape(3, 20, 2000)
    assert abs(correlation(image[0, 19], image[1, 0])) < 0.1
    assert correlation(image[1, 0], image[1, 1]) == pytest.approx(0.7, abs=0.05)


def test_filter_keeps_the_variance() -> None:
    for wanted in (0.0, 0.01, 0.3, 0.95):
        values = taps(wanted)
        assert len(values) % 2 == 1
        assert values @ values == pytest.approx(1.0)
        assert values[1:] @ values[:-1] == pytest.approx(wanted, abs=1e-6)


# --- from ping to ping


def test_frozen_scene_has_frozen_speckle() -> None:
    levels = plain(range_correlation=0.3)
    first, later = (
        image_of(levels, sent_from(7.3, -2.0, 4.0, 0.4)),
        image_of(levels, sent_from(7.3, -2.0, 4.0, 0.4, t_s=60.0, ping=400)),
    )
    np.testing.assert_array_equal(first, later)
    assert abs(correlation(first, image_of(levels, sent_from(7.3, -2.0, 4.0, 0.4), seed=6))) < 0.02


def test_receiver_noise_is_fresh_even_then() -> None:
    alone = plain(noise_counts=50.0, gain=1e-9)
    assert abs(correlation(image_of(alone, sent_from(ping=1)), image_of(alone, sent_from(ping=2)))) < 0.02


@pytest.mark.parametrize("looks", [1, 3])
@pytest.mark.parametrize("echo_share", [0.3, 0.5, 0.667, 0.9])
def test_noise_and_a_frozen_echo_add_up_as_fields(looks: int, echo_share: float) -> None:
    levels = plain(float(looks), noise_counts=GAIN * math.sqrt(1.0 / echo_share - 1.0))
    reported = correlation(*(np.square(image_of(levels, sent_from(ping=ping))) for ping in (1, 2)))
    echo, *noise = np.random.default_rng(3).standard_normal((3, looks, 2, 100_000))
    sums = [np.sqrt(echo_share) * echo + np.sqrt(1.0 - echo_share) * one for one in noise]
    assert reported == pytest.approx(correlation(*(np.square(one).sum(axis=(0, 1)) for one in sums)), abs=0.015)


@pytest.mark.parametrize("range_correlation", [0.0, 0.4])
def test_motion_along_a_beam_renews_speckle_cell_by_cell(range_correlation: float) -> None:
    levels = plain(range_correlation=range_correlation)
    start, middle = image_of(levels), slice(28, 32)
    for cells, rest in ((0.1, 0.9), (0.5, 0.5), (0.9, 0.1), (1.0, 0.0), (30.0, 0.0)):
        moved = image_of(levels, sent_from(north=cells * SEABAT.dr_m))
        assert correlation(start[middle], moved[middle]) == pytest.approx(rest, abs=0.04), f"{cells} cells"


def test_motion_across_a_beam_counts_by_beam_widths() -> None:
    start, moved = image_of(plain()), image_of(plain(), sent_from(east=0.5))
    for metres in (25.0, 50.0, 90.0):
        near = slice(round(metres / 0.05) - 50, round(metres / 0.05) + 50)
        # beams 29 and 30 also see the step along them, 0.5 sin(0.75 deg) m
        along = 1.0 - 0.5 * np.sin(0.5 * BEAM) / SEABAT.dr_m
        expected = (1.0 - 0.5 / (metres * BEAM)) * along
        assert correlation(start[29:31, near], moved[29:31, near]) == pytest.approx(expected, abs=0.12)


@pytest.mark.parametrize("heading", [0, 7, -100])
@pytest.mark.parametrize("cells", [0.1, 0.3, 0.6])
def test_motion_across_a_beam_does_not_count_along_it(heading: int, cells: float) -> None:
    sonar = make_sonar(SonarFile(name="x", frequency_hz=4e5, bearing_deg=[0.0], beam_width_deg=3.0, range0_m=0.05,
                                 dr_m=0.05, samples=2000))  # fmt: skip
    yaw, side, near = heading * sonar.beam_width_rad, cells * 60.0 * sonar.beam_width_rad, slice(1150, 1250)
    moved = sent_from(-side * np.sin(yaw), side * np.cos(yaw), yaw=yaw)
    pairs = [
        [image_of(plain(), sent, seed, sonar)[:, near] for sent in (sent_from(yaw=yaw), moved)] for seed in range(9)
    ]
    assert correlation(*np.moveaxis(np.array(pairs), 1, 0)) == pytest.approx(1.0 - cells, abs=0.06)


def test_turning_renews_speckle_by_beam_widths_and_turning_back_restores_it() -> None:
    start = image_of(plain(), sent_from(yaw=0.3))
    for widths, rest in ((0.2, 0.8), (0.7, 0.3), (1.0, 0.0)):
        turned = image_of(plain(), sent_from(yaw=0.3 + widths * BEAM))
        assert correlation(start, turned) == pytest.approx(rest, abs=0.02)
    np.testing.assert_array_equal(image_of(plain(), sent_from(yaw=0.3)), start)


@pytest.mark.parametrize("width_deg", [1.5, 1.7])
def test_speckle_stays_where_heading_passes_180_degrees(width_deg: float) -> None:
    sonar = make_sonar(SonarFile(name="small", frequency_hz=455e3, beams_per_plane=20, beam_spacing_deg=2.0,
                                 beam_width_deg=width_deg, range0_m=0.1, dr_m=0.1, samples=500))  # fmt: skip
    turn = 0.2 * np.radians(width_deg)
    before, after = (
        image_of(plain(), sent_from(3.0, 4.0, yaw=np.pi + side * turn / 2), sonar=sonar) for side in (-1, 1)
    )
    assert correlation(before, after) == pytest.approx(0.8, abs=0.03)


def test_coherence_time() -> None:
    levels = plain(coherence_s=2.0)
    start = image_of(levels, sent_from(t_s=3.1))
    for seconds, rest in ((0.0, 1.0), (0.5, 0.75), (1.9, 0.05), (2.5, 0.0)):
        assert correlation(start, image_of(levels, sent_from(t_s=3.1 + seconds))) == pytest.approx(rest, abs=0.02)


# --- what real sonars show


def test_aris_statistics_are_in_reach() -> None:
    levels = plain(1.15, range_correlation=0.16, beam_correlation=0.03, coherence_s=0.1)
    image, following = image_of(levels), image_of(levels, sent_from(t_s=0.095))
    intensity = np.square(image)
    assert 1.1 < intensity.mean() ** 2 / intensity.var() < 1.2
    assert from_sample_to_sample(image) == pytest.approx(0.16, abs=0.02)
    assert from_beam_to_beam(image) == pytest.approx(0.03, abs=0.02)
    assert correlation(image, following) == pytest.approx(0.05, abs=0.02)


def test_oculus_statistics_are_in_reach() -> None:
    for looks, across in ((2.0, 0.78), (2.8, 0.57)):
        image = image_of(plain(looks, beam_correlation=across))
        assert 0.29 < image.std() / image.mean() < 0.38
        assert from_beam_to_beam(image) == pytest.approx(across, abs=0.03)


# --- the same everywhere


PROGRAM = """
import hashlib, sys
from pathlib import Path
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.sonar.model import load_sonar
config = Path(sys.argv[1])
scene = load_scene(config / "scenes/figure11_imperfect.toml")
images = ImageSimulator(load_sonar(config / "sonars/seabat6012.toml"), scene)
print(hashlib.sha256(b"".join(images.ping(0.15 * k, k, 0, 0).data for k in range(3))).hexdigest())
"""


def test_same_bytes_in_another_process() -> None:
    config = SEABAT_FILE.parents[1]
    reported = [
        subprocess.run([sys.executable, "-c", PROGRAM, str(config)], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    ]
    assert reported[0] == reported[1]
    assert len(reported[0].strip()) == len(hashlib.sha256().hexdigest())


@pytest.mark.parametrize(("looks", "texture"), [(1.0, 1.0), (1.0, 0.3), (2.8, 4.0)])
def test_with_a_texture_intensity_is_k_distributed(looks: float, texture: float) -> None:
    """Moments of a product of two Gamma distributed numbers of mean 1: E I^2 = (1 + 1/looks) (1 + 1/texture)."""
    normal = np.linspace(-TABLE_REACH, TABLE_REACH, TABLE_NODES)
    weight = np.exp(-0.5 * normal**2) / np.exp(-0.5 * normal**2).sum()
    intensity = speckle_amplitudes(looks, texture).astype(np.float64) ** 2
    assert intensity @ weight == pytest.approx(1.0, rel=0.01)
    assert intensity**2 @ weight == pytest.approx((1.0 + 1.0 / looks) * (1.0 + 1.0 / texture), rel=0.03)
