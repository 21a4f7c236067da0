/* Standard deviations of one echo, as Python asks for them. */

#include "ods/pipeline/measure/features.h"
#include "ods/pipeline/measure/sigmas.h"

KERNEL(sigmas_of,
       "f8[15] features, float point_m, float beside_m, float range_m, float dr_m, " LAWS ", out f8[4] sigmas")
{
    const Laws laws = laws_at(arguments + 5);
    const Sigmas sigmas = sigmas_of_features(ARRAY(const double, 0), &laws, FLOAT(1), FLOAT(2), FLOAT(3), FLOAT(4));
    memcpy(ARRAY(double, 9), &sigmas, sizeof sigmas);
}

KERNEL(outputs_of, "f8[15] features, f8[:,24] hidden, f8[25,outputs] out, out f8[outputs] sums")
{
    if (SIZE(1, 0) > 0 && SIZE(1, 0) <= FEATURES + 1)
        find_outputs(ARRAY(const double, 0), law_at(arguments + 1), ARRAY(double, 3));
}
