/* What echoes are computed over: range bins of a row, angles. */

#ifndef ODS_FAN_H
#define ODS_FAN_H

#include "kernel.h"

/* A right angle, rad. */
#define RIGHT (0.5 * PI)

/* Range bins [first, last) of a row, as far as something was written. */
typedef struct {
    int64_t first, last;
} Bins;

#define NO_BINS ((Bins){INT64_MAX, 0})

/* Returns the bins from the first to the last of both. */
static inline Bins both_bins(Bins one, Bins other)
{
    return (Bins){smaller_i(one.first, other.first), larger_i(one.last, other.last)};
}

#endif
