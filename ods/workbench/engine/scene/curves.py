"""The curves behind a simulated image: S(beta), figure 8 of [SSIE], the beam pattern, and how a surface reflects."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.echo.surface.reflection import reflectivity
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.sonar.patterns import ELEVATION_NODES, NODES_PER_WIDTH

WIDEST_DEG = 40.0
"""Off a beam's axis, as far as the beam pattern is drawn."""
FAINTEST_DB = -80.0


class Curve(NamedTuple):
    """A curve."""

    x: Floats
    y: Floats


def vertical_pattern(sonar: SonarModel) -> list[Curve]:
    """Return for each plane the vertical sensitivity S, dB, emission or reception alone, over elevation, degrees."""
    elevation = np.arcsin(np.linspace(-1.0, 1.0, ELEVATION_NODES))
    even = np.radians(np.linspace(-90.0, 90.0, 361))
    return [
        Curve(np.degrees(even), 0.5 * _decibels(np.interp(even, elevation, plane))) for plane in sonar.vertical_two_way
    ]


def beam_pattern(sonar: SonarModel) -> Curve:
    """Return a beam's horizontal pattern, dB, over degrees off its axis."""
    running = sonar.horizontal_cumulative
    offset_deg = (np.arange(len(running) - 1) + 0.5 - len(running) // 2) / NODES_PER_WIDTH
    offset_deg *= np.degrees(sonar.beam_width_rad)
    shown = np.abs(offset_deg) <= WIDEST_DEG
    power = np.diff(running)[shown] * NODES_PER_WIDTH
    return Curve(offset_deg[shown], _decibels(power))


def reflection(surface: Surface) -> Curve:
    """Return gamma of eq. 3 over the angle of incidence, degrees."""
    angle = np.radians(np.linspace(0.0, 90.0, 181))
    sigma = np.radians(surface.sigma_deg)
    gamma = [reflectivity(float(np.cos(alpha)), surface.cd, surface.cs, float(sigma)) for alpha in angle]
    return Curve(np.degrees(angle), np.array(gamma))


def _decibels(power: Floats) -> Floats:
    return np.asarray(10.0 * np.log10(np.maximum(power, 10.0 ** (0.1 * FAINTEST_DB))))
