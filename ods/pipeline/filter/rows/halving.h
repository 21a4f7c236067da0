/* Quantiles by halving an interval: no sorting, and it vectorises. */

#ifndef ODS_HALVING_H
#define ODS_HALVING_H

#include "kernel.h"

/* Steps: it is then known to a thousandth of the interval. */
#define HALVINGS 10

/* Returns the median of values that lie between low and high. */
static inline float median_between(float low, float high, const float *values, int64_t count)
{
    for (int64_t step = 0; step < HALVINGS; step++) {
        const float at = 0.5f * (low + high);
        int32_t above = 0;
        for (int64_t i = 0; i < count; i++)
            above += values[i] > at;
        if (2 * above >= count)
            low = at;
        else
            high = at;
    }
    return 0.5f * (low + high);
}

#endif
