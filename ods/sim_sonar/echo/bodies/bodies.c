/* Where rays meet bodies, for Python. */

#include "ods/sim_sonar/echo/bodies/bodies.h"

KERNEL_FLOAT(far_m, "")
{
    (void)arguments;
    return FAR;
}

/* Sets `met` to range and cos(incidence angle) (see `hit`). */
KERNEL(hit_body, "r152[1] body, float x, float y, float z, out f8[2] met")
{
    const Hit found = hit(ARRAY(const Body, 0), FLOAT(1), FLOAT(2), FLOAT(3));
    ARRAY(double, 4)[0] = found.range_m;
    ARRAY(double, 4)[1] = found.cosine;
}

/* Sets the range, from the origin, at which each ray along a unit vector first meets one of the bodies; FAR: none. */
KERNEL(first_hits, "r152[bodies] all, f8[rays,3] rays, out f8[rays] range_m")
{
    const Body *all = ARRAY(const Body, 0);
    const double *rays = ARRAY(double, 1);
    double *range_m = ARRAY(double, 2);
    for (int64_t k = 0; k < SIZE(1, 0); k++) {
        double nearest = FAR;
        for (int64_t i = 0; i < SIZE(0, 0); i++)
            nearest = smaller(nearest, hit(&all[i], rays[3 * k], rays[3 * k + 1], rays[3 * k + 2]).range_m);
        range_m[k] = nearest;
    }
}
