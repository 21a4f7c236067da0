"""Reflection of surfaces: eqs. 3 and 4 of [SSIE].

[SSIE] L. Henriksen, IEEE AUV Symposium 1996, pp. 333-340.
"""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native

MIN_NODES, MAX_NODES = 1024, 65536
"""Least and greatest number of intervals of a table of reflectivity."""
NODES_PER_LOBE = 16.0
"""Intervals of such a table over the 1 - cos(alpha) in which the facets' lobe falls to 1 / e^0.5, twice."""


def reflectivity(cos_alpha: float, cd: float, cs: float, sigma_rad: float) -> float:
    """Return gamma, reflected over incident intensity at incidence angle alpha (eqs. 3 and 4); 0 behind the surface."""
    return float(native.reflectivity(cos_alpha, cd, cs, sigma_rad))


def reflectivity_table(cd: float, cs: float, sigma_rad: float) -> Floats:
    """Return eqs. 3 and 4 over cos(alpha), even from 0 to 1, fine enough for the facets' Gaussian lobe."""
    nodes = min(MAX_NODES, max(MIN_NODES, math.ceil(NODES_PER_LOBE / sigma_rad**2))) + 1
    return np.array([reflectivity(cosine, cd, cs, sigma_rad) for cosine in np.linspace(0.0, 1.0, nodes)])
