/* Tables of a function over [0, 1], looked up by linear interpolation. */

#ifndef ODS_INTERPOLATION_H
#define ODS_INTERPOLATION_H

#include "kernel.h"

/* Returns `table` of at least two nodes, even from 0 to 1, at `place`; the ends hold beyond, the first for NaN. */
static inline double interpolate(const double *table, int64_t nodes, double place)
{
    const double where = smaller(larger(place, 0.0), 1.0) * (double)(nodes - 1);
    const int32_t node = (int32_t)smaller(where, (double)(nodes - 2));
    return table[node] + (where - node) * (table[node + 1] - table[node]);
}

#endif
