/* One echo: a row of echoes.ECHO. */

#ifndef ODS_ECHO_H
#define ODS_ECHO_H

#include "kernel.h"

typedef struct {
    double range_m, bearing_rad, radius_m;
    double peak, mean, snr_db;
    int64_t cells;
    double range_extent_m, bearing_extent_rad;
    double sigma_range_m, sigma_bearing_rad, sigma_radius_m;
    double amplitude, elevation_rad;
    double near_m, sigma_near_m;
    bool cut;
    double onset;
    double front; /* fronts/judge.py fills it in */
    double half_length_m, half_width_m, axis_rad;
} Echo;

/* What a signature calls it. */
#define ECHO "r176"
_Static_assert(sizeof(Echo) == 176, "ECHO");

#endif
