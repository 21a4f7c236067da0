/* How surfaces reflect: eqs. 3 and 4 of [SSIE] (see reflection.py). */

#ifndef ODS_REFLECTION_H
#define ODS_REFLECTION_H

#include "kernel.h"

/* Returns gamma, reflected over incident intensity at incidence angle alpha (eqs. 3 and 4).

   gamma = Cd cos(alpha) + Cs G exp(-alpha^2 / (2 sigma^2)) / cos(alpha) with G = min(1, 2 cos^2(alpha)). The ratio
   G / cos(alpha) is taken as min(1 / cos, 2 cos), which stays finite at grazing incidence. Behind the surface it is
   0. */
static inline double reflectivity_at(double cos_alpha, double cd, double cs, double sigma_rad)
{
    if (cos_alpha <= 0.0)
        return 0.0;
    const double cosine = smaller(cos_alpha, 1.0), facets = exp(-0.5 * square(acos(cosine) / sigma_rad));
    return cd * cosine + cs * facets * smaller(1.0 / cosine, 2.0 * cosine);
}

#endif
