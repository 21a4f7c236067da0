/* Counts of false alarms by part of the fan and by radius, and their density at the place of an echo (clutter.py). */

#include "ods/tracker/measurement/model.h"

/* Width of a class of radius; the last one has all that is larger, */
#define RADIUS_STEP_M 0.5
/* taken to be even up to this radius. */
#define LARGEST_RADIUS_M 25.0
/* Share of an even distribution in what was counted, so that nothing is impossible, and of one that is even over the
   bearings of a range. */
#define PRIOR_SHARE 0.25

/* The fan and its parts that are counted apart. */
typedef struct {
    double nearest, farthest;
    double port, opening; /* rad */
    int64_t ranges, bearings;
} Fan;

static int64_t class_of(double share, int64_t classes)
{
    return (int64_t)smaller(larger(share * (double)classes, 0.0), (double)classes - 1.0);
}

static int64_t ring_of(double range_m, const Fan *fan)
{
    return class_of((range_m - fan->nearest) / (fan->farthest - fan->nearest), fan->ranges);
}

static int64_t column_of(double bearing, const Fan *fan)
{
    return class_of((bearing - fan->port) / fan->opening, fan->bearings);
}

static int64_t radius_class(double radius, int64_t radii)
{
    return radius > 0.0 ? (int64_t)smaller(radius / RADIUS_STEP_M, (double)radii - 1.0) : 0;
}

static double radius_width(int64_t class, int64_t radii)
{
    return class < radii - 1 ? RADIUS_STEP_M : LARGEST_RADIUS_M - RADIUS_STEP_M * (double)class;
}

static double sum_of(const double *values, int64_t count)
{
    double sum = 0.0;
    for (int64_t k = 0; k < count; k++)
        sum += values[k];
    return sum;
}

/* Moves the running means by `weight` towards the counts of this scan; returns the sum of `by_part`.

   processed: share of each class of range that was processed: what was not stays as it is. */
KERNEL_FLOAT(
    clutter_count,
    "f8[12,m] echoes, float nearest, float farthest, float port, float opening, float weight, f8[ranges] processed, "
    "out f8[ranges,bearings] by_part, out f8[radii] by_radius")
{
    const int64_t m = SIZE(0, 1), radii = SIZE(8, 0);
    const EchoRows echoes = echo_rows(ARRAY(double, 0), m);
    const Fan fan = {FLOAT(1), FLOAT(2), FLOAT(3), FLOAT(4), SIZE(7, 0), SIZE(7, 1)};
    const double weight = FLOAT(5), *processed = ARRAY(const double, 6);
    double *by_part = ARRAY(double, 7), *by_radius = ARRAY(double, 8);
    for (int64_t ring = 0; ring < fan.ranges; ring++)
        for (int64_t column = 0; column < fan.bearings; column++)
            by_part[ring * fan.bearings + column] *= 1.0 - weight * processed[ring];
    for (int64_t k = 0; k < radii; k++)
        by_radius[k] *= 1.0 - weight;
    for (int64_t j = 0; j < m; j++) {
        by_part[ring_of(echoes.range_m[j], &fan) * fan.bearings + column_of(echoes.bearing[j], &fan)] += weight;
        by_radius[radius_class(echoes.radius[j], radii)] += weight;
    }
    return sum_of(by_part, fan.ranges * fan.bearings);
}

/* Fills in the fields of `ClutterDensity` at each echo; `fewest`: false alarms a scan are never taken to be rarer. */
KERNEL(clutter_density,
       "f8[12,m] echoes, float nearest, float farthest, float port, float opening, f8[ranges,bearings] by_part, "
       "f8[radii] by_radius, float fewest, out f8[3,m] density")
{
    const int64_t m = SIZE(0, 1), radii = SIZE(6, 0);
    const EchoRows echoes = echo_rows(ARRAY(double, 0), m);
    const Fan fan = {FLOAT(1), FLOAT(2), FLOAT(3), FLOAT(4), SIZE(5, 0), SIZE(5, 1)};
    const double *by_part = ARRAY(const double, 5), *by_radius = ARRAY(const double, 6), fewest = FLOAT(7);
    double *per_m2 = ARRAY(double, 8), *per_scan = per_m2 + m, *of_radius = per_scan + m;
    const double parts = (double)(fan.ranges * fan.bearings);
    const double all_radii = larger(sum_of(by_radius, radii), NOT_ZERO);
    const double even = PRIOR_SHARE * larger(sum_of(by_part, fan.ranges * fan.bearings), fewest) / parts;
    const double area = (fan.farthest - fan.nearest) * fan.opening / parts;
    double *in_ring = SCRATCH(double, fan.ranges);
    for (int64_t ring = 0; ring < fan.ranges; ring++)
        in_ring[ring] = PRIOR_SHARE * sum_of(by_part + ring * fan.bearings, fan.bearings) / (double)fan.bearings;
    for (int64_t j = 0; j < m; j++) {
        const int64_t ring = ring_of(echoes.range_m[j], &fan);
        const double own = by_part[ring * fan.bearings + column_of(echoes.bearing[j], &fan)];
        const double here = larger(even + in_ring[ring] + (1.0 - 2.0 * PRIOR_SHARE) * own, fewest / parts);
        per_m2[j] = here / (area * larger(echoes.range_m[j], NEAREST_M));
        per_scan[j] = here * parts;
        const int64_t class = radius_class(echoes.radius[j], radii);
        const double share = PRIOR_SHARE / (double)radii + (1.0 - PRIOR_SHARE) * by_radius[class] / all_radii;
        of_radius[j] = share / radius_width(class, radii);
    }
}
