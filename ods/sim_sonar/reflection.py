"""How surfaces reflect: eqs. 3 and 4 of [SSIE].

[SSIE] L. Henriksen, IEEE AUV Symposium 1996, pp. 333-340.
"""

import math

from ods.sim_sonar.jit import compiled


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
