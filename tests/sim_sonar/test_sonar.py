from pathlib import Path

import numpy as np
import pytest
from scipy import integrate

from ods.sim_sonar.sonar.model import load_sonar
from ods.sim_sonar.sonar.patterns import ELEVATION_NODES, aperture_table

SONARS = Path(__file__).parents[2] / "config/sonars"


def test_aperture_is_the_fourth_power_of_its_diffraction_integral() -> None:
    wavelengths, axis = 5.0, np.radians(10.0)
    table = aperture_table(wavelengths, axis)
    sines = np.linspace(-1.0, 1.0, ELEVATION_NODES)
    for off_deg in (0.0, 3.0, 8.0, 15.0, 16.5, 40.0):
        phase = 2.0 * np.pi * np.sin(np.radians(off_deg))
        half = wavelengths / 2
        field = integrate.quad(lambda z, phase=phase: np.cos(phase * z), -half, half)[0] / wavelengths
        assert np.interp(np.sin(axis + np.radians(off_deg)), sines, table) == pytest.approx(field**4, abs=1e-4)


def test_three_planes_see_60_degrees() -> None:
    sonar = load_sonar(SONARS / "seabat6012_3plane.toml")
    assert (sonar.planes, sonar.beams, sonar.samples) == (3, 180, 2000)
    sines = np.linspace(-1.0, 1.0, ELEVATION_NODES)
    peaks = np.degrees(np.arcsin(sines[np.argmax(sonar.vertical_two_way, axis=1)]))
    np.testing.assert_allclose(peaks, [-20.0, 0.0, 20.0], atol=0.1)


def test_modern_sonar_has_512_beams_and_a_20_degree_lobe() -> None:
    sonar = load_sonar(SONARS / "multibeam512.toml")
    assert (sonar.beams, sonar.samples) == (512, 2000)
    assert sonar.range_max_m == pytest.approx(100.0)
    sines = np.linspace(-1.0, 1.0, ELEVATION_NODES)
    edge = np.interp(np.sin(np.radians(10.0)), sines, sonar.vertical_two_way[0])
    assert 10 * np.log10(edge) == pytest.approx(-6.0, abs=0.2)
