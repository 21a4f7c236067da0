/* Sonars of several planes: the echoes that planes next to each other have of the same body become one. */

#include "ods/tracker/measurement/coverage/normal.h"
#include "ods/tracker/measurement/model.h"

/* Tells whether two echoes are of planes next to each other, whose openings touch, and agree. */
static bool is_same_body(EchoRows echoes, int64_t i, int64_t j, double reach)
{
    const double apart = fabs(echoes.elevation[i] - echoes.elevation[j]);
    if (!(0.0 < apart && apart <= reach))
        return false;
    const double longer = fabs(echoes.range_m[i] - echoes.range_m[j]);
    const double aside = fabs(wrapped(echoes.bearing[i] - echoes.bearing[j]));
    return longer <= BEYOND_CHANCE * length_of(echoes.sigma_range[i], echoes.sigma_range[j]) &&
           aside <= BEYOND_CHANCE * length_of(echoes.sigma_bearing[i], echoes.sigma_bearing[j]);
}

/* Puts the echoes of each body together, in `made`, which is a copy of `table`: what is left of them is `kept`. The
   loudest first: `order`. `side_lobe_db`: see planes.py. */
KERNEL(merge_planes,
       "f8[12,m] table, i8[m] order, float plane_half_rad, float side_lobe_db, out f8[12,m] made, out b1[m] kept")
{
    const int64_t m = SIZE(0, 1), *order = ARRAY(int64_t, 1);
    const double plane_half_rad = FLOAT(2), reach = 2.0 * plane_half_rad * ROUNDED;
    const EchoRows echoes = echo_rows(ARRAY(double, 0), m), made = echo_rows(ARRAY(double, 4), m);
    bool *kept = ARRAY(bool, 5);
    for (int64_t j = 0; j < m; j++) {
        made.half_vertical[j] = plane_half_rad;
        kept[j] = true;
    }
    for (int64_t p = 0; p < m; p++) {
        const int64_t i = order[p];
        bool alone = true;
        for (int64_t q = p + 1; q < m && kept[i]; q++) {
            const int64_t j = order[q];
            if (!kept[j] || !is_same_body(echoes, i, j, reach))
                continue;
            const double louder_db = echoes.strength[i] - echoes.strength[j];
            if (alone && louder_db < FLOAT(3)) {
                const double share = 1.0 / (1.0 + pow(10.0, -louder_db / 20.0));
                made.elevation[i] = share * echoes.elevation[i] + (1.0 - share) * echoes.elevation[j];
                made.half_vertical[i] = share * plane_half_rad;
            }
            if (echoes.radius[j] > made.radius[i]) {
                made.radius[i] = echoes.radius[j];
                made.sigma_radius[i] = echoes.sigma_radius[j];
            }
            kept[j] = alone = false;
        }
    }
}
