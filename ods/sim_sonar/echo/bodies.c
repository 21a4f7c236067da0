/* Where rays meet bodies, for Python. */

#include "ods/sim_sonar/echo/bodies.h"

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
