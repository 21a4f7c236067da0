/* How long and wide an echo is, and along which line: by the second moments of the area that it covers.

   A uniform strip of half length a has the variance a^2 / 3 along it, and likewise across. */

#ifndef ODS_OUTLINE_H
#define ODS_OUTLINE_H

#include "ods/pipeline/measure/circle/depth.h"

/* In the sonar's plane. */
typedef struct {
    double half_length_m, half_width_m;
    double axis_rad; /* of the long axis, from the line of sight to starboard, within +-pi/2 */
} Outline;

/* Sums over a region's area, along the line of sight to its centre and across. */
typedef struct {
    double area, x, y, xx, xy, yy;
} Moments;

/* Adds a run of `beam` from `near` to `far`, whose bearings from the centre are multiplied by `narrower`. */
static inline void add_run(Moments *sum, double near_m, double far_m, double from_rad, double to_rad, double narrower)
{
    const double middle = 0.5 * (near_m + far_m), depth = larger(1e-6, far_m - near_m);
    const double angle = 0.5 * (from_rad + to_rad) * narrower, width = middle * (to_rad - from_rad) * narrower;
    const double x = middle * cos(angle), y = middle * sin(angle), area = depth * larger(1e-6, width);
    sum->area += area;
    sum->x += area * x, sum->y += area * y;
    sum->xx += area * (x * x + square(depth) / 12.0);
    sum->xy += area * x * y;
    sum->yy += area * (y * y + square(width) / 12.0);
}

/* Returns the outline of an echo, seen under `across` rad at `centre` once the beam's width is taken out. */
static inline Outline outline_of(const Region *region, Ends ends, const double *borders, double centre, double across)
{
    const double narrower = held(across / (borders[region->high + 1] - borders[region->low]), 0.0, 1.0);
    Moments sum = {0};
    for (int64_t i = 0; i < region->count; i++) {
        const double *border = &borders[region->runs[i].beam];
        add_run(&sum, ends.near_m[i], ends.far_m[i], border[0] - centre, border[1] - centre, narrower);
    }
    const double x = sum.x / sum.area, y = sum.y / sum.area;
    const double along = larger(0.0, sum.xx / sum.area - x * x), beside = larger(0.0, sum.yy / sum.area - y * y);
    const double mixed = sum.xy / sum.area - x * y;
    const double mean = 0.5 * (along + beside), half_gap = distance_of(0.5 * (along - beside), mixed);
    return (Outline){
        .half_length_m = sqrt(3.0 * (mean + half_gap)),
        .half_width_m = sqrt(3.0 * larger(0.0, mean - half_gap)),
        .axis_rad = 0.5 * atan2(2.0 * mixed, along - beside),
    };
}

#endif
