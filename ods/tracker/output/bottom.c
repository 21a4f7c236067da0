/* What of the objects is the bottom, as far as heights show.

   The bottom right below the vehicle is known from its altitude. Farther away it lies as deep but for slope and
   roughness, whose standard deviations are settings. An object's height over it is known as well as its depth, which a
   sonar of one plane hardly sees: then nothing is said of it that is not so. */

#include "ods/tracker/measurement/coverage/normal.h"

/* What stands on the bottom reaches so many times as high as the middle of what is seen of it. */
#define HIGHER 2.0

/* The probability that objects reach no higher than `clearance_m` over the bottom, given that nothing is below it; of
   the height of what is seen of them, m, and its standard deviation. */
KERNEL(reach_no_higher, "f8[n] height_m, f8[n] sigma_m, float clearance_m, out f8[n] probability")
{
    const double *height = ARRAY(double, 0), *sigma = ARRAY(double, 1), most = FLOAT(2) / HIGHER;
    double *probability = ARRAY(double, 3);
    for (int64_t i = 0; i < SIZE(0, 0); i++) {
        const double lower = normal_below(-height[i] / sigma[i]), above = normal_below(height[i] / sigma[i]);
        const double between = (normal_below((most - height[i]) / sigma[i]) - lower) / above;
        /* what is farther below the bottom is none of it: the bottom falls off there, and how deep it is, is not known */
        probability[i] = height[i] > -BEYOND_CHANCE * sigma[i] ? smaller(larger(between, 0.0), 1.0) : 0.0;
    }
}
