"""How surfaces reflect: eqs. 3 and 4 of [SSIE].

[SSIE] L. Henriksen, IEEE AUV Symposium 1996, pp. 333-340.
"""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.kernel import compiled

MIN_NODES, MAX_NODES = 1024, 65536
"""Least and greatest number of intervals of a table of reflectivity."""
NODES_PER_LOBE = 16.0
"""Intervals of such a table over the 1 - cos(alpha) in which the facets' lobe falls to 1 / e^0.5, twice."""


@compiled
def reflectivity(cos_alpha: float, cd: float, cs: float, sigma_rad: float) -> float:
    """Return gamma, reflected over incident intensity at incidence angle alpha (eqs. 3 and 4).

    gamma = Cd cos(alpha) + Cs G exp(-alpha^2 / (2 sigma^2)) / cos(alpha) with G = min(1, 2 cos^2(alpha)). The ratio
    G / cos(alpha) is taken as min(1 / cos, 2 cos), which stays finite at grazing incidence. Behind the surface it is 0.
    """
    if cos_alpha <= 0.0:
        return 0.0
    cosine = min(cos_alpha, 1.0)
    alpha = math.acos(cosine)
    facets = math.exp(-0.5 * (alpha / sigma_rad) ** 2)
    return cd * cosine + cs * facets * min(1.0 / cosine, 2.0 * cosine)


def reflectivity_table(cd: float, cs: float, sigma_rad: float) -> Floats:
    """Return eqs. 3 and 4 over cos(alpha), even from 0 to 1, fine enough for the facets' Gaussian lobe."""
    nodes = min(MAX_NODES, max(MIN_NODES, math.ceil(NODES_PER_LOBE / sigma_rad**2))) + 1
    return np.array([reflectivity(cosine, cd, cs, sigma_rad) for cosine in np.linspace(0.0, 1.0, nodes)])
