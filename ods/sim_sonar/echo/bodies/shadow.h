/* Shadows: what an object hides of the sea-bed behind it (see shadow.py). */

#ifndef ODS_SHADOW_H
#define ODS_SHADOW_H

#include "kernel.h"

/* shadow.SHADE: of the rays of one bearing that have met an object the least and greatest bearing, sines of least and
   greatest elevation, range, the object's number. */
typedef struct {
    double west, east, low, high, range_m;
    int64_t which;
} Shade;

/* Shades in a signature: one argument. */
#define SHADES "r48[shades] shades"
_Static_assert(sizeof(Shade) == 48, "as in SHADES");

/* What one object hides of a column: the share of its width; the rest is the mean over that. */
typedef struct {
    double share, low, high, range_m;
    int64_t which;
} MeanShade;

/* Sets `out` (count,) to one mean shade of each object on a column between two bearings; returns how many. */
static inline int64_t shades_on(const Shade *shades, int64_t count, double west, double east, MeanShade *out)
{
    int64_t objects = 0;
    for (int64_t k = 0; k < count; k++) {
        const Shade *shade = &shades[k];
        const double part = (smaller(east, shade->east) - larger(west, shade->west)) / (east - west);
        if (!(part > 0.0))
            continue;
        if (objects == 0 || out[objects - 1].which != shade->which)
            out[objects++] = (MeanShade){0.0, 0.0, 0.0, 0.0, shade->which};
        MeanShade *mean = &out[objects - 1];
        mean->share += part;
        mean->low += part * shade->low;
        mean->high += part * shade->high;
        mean->range_m += part * shade->range_m;
    }
    for (int64_t k = 0; k < objects; k++) {
        out[k].low /= out[k].share;
        out[k].high /= out[k].share;
        out[k].range_m /= out[k].share;
    }
    return objects;
}

/* Returns how much of the elevations with sines `low` to `high`, `distance` m away, a column of the fan sees.

   What two objects hide is taken as the product of what each hides, which is exact but where the edges of both
   cross. */
static inline double visible_share(const MeanShade *shades, int64_t count, double low, double high, double distance)
{
    double seen = 1.0;
    for (int64_t k = 0; k < count; k++)
        if (shades[k].range_m < distance) {
            const double part = smaller(high, shades[k].high) - larger(low, shades[k].low);
            seen *= 1.0 - smaller(1.0, shades[k].share * larger(0.0, part) / (high - low));
        }
    return seen;
}

#endif
