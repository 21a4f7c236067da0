/* The echoes of a ping in the global frame: `GlobalEchoes` of seen.py. */

#ifndef ODS_SEEN_H
#define ODS_SEEN_H

#include "kernel.h"

typedef double Pair[2];
typedef double Moments[2][2];

/* `GlobalEchoes` in a signature: nine arguments. */
#define SEEN                                                                                                            \
    "f8[m,2] place, f8[m] radius, f8[m] sigma, f8[m] near, f8[m] sigma_near, f8[m] sigma_along, f8[m] sigma_radius, "   \
    "f8[m,2,2] extent, f8[m] length"

typedef struct {
    int64_t m;
    const Pair *place;
    const double *radius, *sigma, *near, *sigma_near, *sigma_along, *sigma_radius;
    const Moments *extent;
    const double *length;
} Seen;

static inline Seen seen_from(const Argument *arguments, int k)
{
    return (Seen){SIZE(k, 0), ARRAY(const Pair, k), ARRAY(double, k + 1), ARRAY(double, k + 2), ARRAY(double, k + 3),
                  ARRAY(double, k + 4), ARRAY(double, k + 5), ARRAY(double, k + 6), ARRAY(const Moments, k + 7),
                  ARRAY(double, k + 8)};
}

#endif
