/* Planes as Python makes them. */

#include "ods/sim_sonar/echo/surface/flat_surface.h"

KERNEL(flat_surface, "float edge_m, float dr_m, float height_m, float cd, float cs, float sigma_rad, "
                     "out f8[samples] weight, out f8[:] nearness")
{
    fill_flat_surface(FLOAT(0), FLOAT(1), smaller_i(SIZE(6, 0), SIZE(7, 0) - 1), FLOAT(2), FLOAT(3), FLOAT(4), FLOAT(5),
                      ARRAY(double, 6), ARRAY(double, 7));
}
