/* How a surface reflects, for Python. */

#include "ods/sim_sonar/echo/surface/reflection.h"

KERNEL_FLOAT(reflectivity, "float cos_alpha, float cd, float cs, float sigma_rad")
{
    return reflectivity_at(FLOAT(0), FLOAT(1), FLOAT(2), FLOAT(3));
}
