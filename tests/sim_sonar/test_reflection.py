import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ods.sim_sonar.echo.surface.reflection import reflectivity
from ods.sim_sonar.sonar.patterns import ELEVATION_NODES, horizontal_cumulative, horizontal_power, two_way_table


@pytest.mark.parametrize(
    ("alpha_deg", "expected"),
    [  # Cd = 0.3, Cs = 0.5, sigma = 0.4 rad, worked out by hand from eqs. 3 and 4
        (0.0, 0.8),
        (30.0, 0.3 * 0.8660254 + 0.5 * 0.4245455 / 0.8660254),
        (45.0, 0.3 * 0.7071068 + 0.5 * 0.1454895 * 1.4142136),
        (60.0, 0.3 * 0.5 + 0.5 * 0.0324861 * 1.0),
        (75.0, 0.3 * 0.2588190 + 0.5 * 0.0047263 * 0.5176381),
        (90.0, 0.0),
    ],
)
def test_eq_3_and_4_at_tabulated_angles(alpha_deg: float, expected: float) -> None:
    assert reflectivity(math.cos(math.radians(alpha_deg)), 0.3, 0.5, 0.4) == pytest.approx(expected, abs=2e-5)


@settings(deadline=None)  # on a busy machine
@given(st.floats(-1.1, 1.1), st.floats(0, 2), st.floats(0, 2), st.floats(1e-3, 1.5))
def test_reflectivity_is_finite_and_never_negative(cosine: float, cd: float, cs: float, sigma: float) -> None:
    gamma = reflectivity(cosine, cd, cs, sigma)
    assert 0.0 <= gamma <= cd + 1.5 * cs
    if cosine <= 0.0:
        assert gamma == 0.0


def test_horizontal_pattern_is_that_of_a_kaiser_tapered_array() -> None:
    taper = 3.2115  # sinh(B) / B = 10 ** ((25 - 13.26) / 20)
    elements = 400
    window = np.kaiser(elements, taper)
    phase = np.linspace(0.0, 0.2, 4001)  # rad between neighbouring elements
    place = np.arange(elements) - 0.5 * (elements - 1)
    array_power = np.square(np.cos(np.outer(phase, place)) @ window / window.sum())
    half_power = np.interp(0.5, array_power[200::-1], phase[200::-1])
    ours = horizontal_power(0.5 * phase / half_power, -25.0)
    np.testing.assert_allclose(ours, array_power, atol=2e-4)


def test_horizontal_pattern_levels() -> None:
    assert horizontal_power([0.0, 0.5, -0.5], -25.0) == pytest.approx([1.0, 0.5, 0.5], abs=1e-9)
    lobes = horizontal_power(np.linspace(1.4, 60.0, 20000), -25.0)
    assert 10 * np.log10(lobes.max()) == pytest.approx(-25.0, abs=0.1)
    unshaded = horizontal_power(np.linspace(1.3, 20.0, 20000), -13.3)
    assert 10 * np.log10(unshaded.max()) == pytest.approx(-13.3, abs=0.1)


def test_running_integral_ends_at_the_whole_pattern() -> None:
    offset = np.linspace(-40.0, 40.0, 400001)
    whole = np.sum(horizontal_power(offset, -25.0)) * (offset[1] - offset[0])
    assert horizontal_cumulative(-25.0, 40.0)[-1] == pytest.approx(whole, rel=1e-3)


def test_vertical_table_is_the_pattern_about_its_axis() -> None:
    table = two_way_table([0.0, 10.0, 90.0], [0.0, -6.0, -40.0], np.radians(20.0))
    sines = np.linspace(-1.0, 1.0, ELEVATION_NODES)
    at = np.interp(np.sin(np.radians([20.0, 30.0, 10.0, 25.0])), sines, table)
    np.testing.assert_allclose(10 * np.log10(at), [0.0, -6.0, -6.0, -3.0], atol=0.02)
