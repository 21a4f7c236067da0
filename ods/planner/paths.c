/* Paths of a vehicle by what is in their way (conflict.py, unknown.py). */

#include "kernel.h"

#define TURN 6.28318530717958647692

/* North and east, m. */
typedef struct {
    double north, east;
} Place;
_Static_assert(sizeof(Place) == 16, "as in f8[...,2]");

/* Sets `bad` to the integral over time of the squared lack of distance to the obstacle that each path comes nearest to,
   m^2 s, a path through one counting `hit` times. Obstacles at the instants: `_Courses` of conflict.py; `step_s`: time
   before each instant. */
KERNEL(conflict, "f8[n,m,2] paths, f8[m] step_s, f8[k,m,2] places, f8[k] radius_m, f8[k,m] spread_m, float keep_m, "
                 "float hit, out f8[n] bad")
{
    const int64_t m = SIZE(1, 0), obstacles = SIZE(2, 0);
    const double keep = FLOAT(5), hit = FLOAT(6);
    double *worst = SCRATCH(double, m);
    for (int64_t path = 0; path < SIZE(0, 0); path++) {
        const Place *restrict at = ARRAY(const Place, 0) + path * m;
        memset(worst, 0, (size_t)m * sizeof *worst);
        for (int64_t k = 0; k < obstacles; k++) {
            const Place *restrict there = ARRAY(const Place, 2) + k * m;
            const double *restrict spread = ARRAY(const double, 4) + k * m, radius = ARRAY(double, 3)[k];
            for (int64_t j = 0; j < m; j++) {
                const double edge = sqrt(square(at[j].north - there[j].north) + square(at[j].east - there[j].east)) - radius;
                const double lack = larger(keep + spread[j] - edge, 0.0);
                worst[j] = larger(worst[j], lack * lack * (edge < 0.0 ? hit : 1.0));
            }
        }
        double total = 0.0;
        for (int64_t j = 0; j < m; j++)
            total += worst[j] * ARRAY(double, 1)[j];
        ARRAY(double, 7)[path] = total;
    }
}

/* Sets `unknown` to how much of the next `look_m` of each path, as seen from a place, is not known to be empty, m. By
   bearing sector: water that is empty from and to so far, and the nearest obstacle or echo; nearer than both that and
   `own_m` water counts as empty. */
KERNEL(unknown_water, "f8[n,m,2] paths, float north_m, float east_m, f8[sectors] from_m, f8[sectors] to_m, "
                      "f8[sectors] nearest_m, float own_m, float look_m, out f8[n] unknown")
{
    const int64_t m = SIZE(0, 1), sectors = SIZE(3, 0);
    const double own_m = FLOAT(6), look_m = FLOAT(7);
    for (int64_t path = 0; path < SIZE(0, 0); path++) {
        const Place *at = ARRAY(const Place, 0) + path * m;
        double before = 0.0, total = 0.0;
        for (int64_t j = 0; j < m && sectors > 0; j++) {
            const double north = at[j].north - FLOAT(1), east = at[j].east - FLOAT(2);
            const double away = sqrt(north * north + east * east), step = away - before;
            before = away;
            if (!(away <= look_m))
                continue;
            const double turned = atan2(east, north) / TURN, place = (turned < 0.0 ? turned + 1.0 : turned) * (double)sectors;
            const int64_t sector = (int64_t)smaller(larger(place, 0.0), (double)(sectors - 1));
            const bool is_empty = away <= ARRAY(double, 4)[sector] && away >= larger(ARRAY(double, 3)[sector], 0.0);
            if (!is_empty && (away > own_m || away > ARRAY(double, 5)[sector]))
                total += larger(step, 0.0);
        }
        ARRAY(double, 8)[path] = total;
    }
}
