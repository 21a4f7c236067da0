/* The shadow of an object, by the rays that have met it. */

#include "ods/sim_sonar/echo/bodies/shadow.h"
#include "ods/sim_sonar/echo/bodies/bodies.h"
#include "ods/sim_sonar/echo/rays/ray_budget.h"

/* Sets `shades`, from `count` on, to those of one more object; returns how many there are then.

   Its rays met the object at `ranges`, FAR where they did not; there is one shade a bearing at most. */
KERNEL_INT(add_shades, "out " SHADES ", int count, f8[fan_columns,cells] ranges, " RAY_FAN ", int which")
{
    Shade *shades = ARRAY(Shade, 0);
    int64_t count = INT(1);
    const int64_t cells = SIZE(2, 1);
    const RayFan rays = ray_fan_from(arguments, 3);
    for (int64_t a = 0; a < rays.columns && count < SIZE(0, 0); a++) {
        const double *ranges = ARRAY(const double, 2) + a * cells, *elevation = elevations_of(&rays, a);
        int64_t first = cells, last = -1;
        double nearest = FAR;
        for (int64_t e = 0; e < cells; e++)
            if (ranges[e] < FAR) {
                first = smaller_i(first, e);
                last = e;
                nearest = smaller(nearest, ranges[e]);
            }
        if (last >= 0)
            shades[count++] = (Shade){rays.bearing[a], rays.bearing[a + 1], sin(elevation[first]),
                                      sin(elevation[last + 1]), nearest, INT(6)};
    }
    return count;
}
