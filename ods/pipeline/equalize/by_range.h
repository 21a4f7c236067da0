/* Levels of the ranges of an image, limited by those around them. */

#ifndef ODS_BY_RANGE_H
#define ODS_BY_RANGE_H

#include "ods/pipeline/image/samples/samples.h"

/* Returns how many blocks to either side of a range make surroundings of `window` range samples. */
static inline int64_t blocks_around(int64_t window)
{
    return larger_i(1, window / (2 * SAMPLES_OF_BLOCK));
}

/* Returns the (lower) median of a few values; work has room for them. */
static inline float sorted_middle(const float *values, int64_t count, float *work)
{
    for (int64_t i = 0; i < count; i++) {
        const float value = values[i];
        int64_t k = i;
        for (; k > 0 && work[k - 1] > value; k--)
            work[k] = work[k - 1];
        work[k] = value;
    }
    return work[(count - 1) / 2];
}

/* Limits level (samples,) to guard times its surroundings' level, in place.

   The surroundings' level is the median of block means over `reach` blocks to either side, so an edge of a belt keeps
   its place. */
static inline void limit_levels(float *level, int64_t samples, float guard, int64_t reach)
{
    const int64_t count = (samples + SAMPLES_OF_BLOCK - 1) / SAMPLES_OF_BLOCK;
    float *blocks = SCRATCH(float, count), *nearby = SCRATCH(float, smaller_i(count, 2 * reach + 1));
    for (int64_t k = 0; k < count; k++) {
        const float *part = level + k * SAMPLES_OF_BLOCK;
        const int64_t columns = smaller_i(SAMPLES_OF_BLOCK, samples - k * SAMPLES_OF_BLOCK);
        float total = 0.0f;
        for (int64_t j = 0; j < columns; j++)
            total += part[j];
        blocks[k] = total / (float)columns;
    }
    for (int64_t k = 0; k < count; k++) {
        const int64_t first = larger_i(0, k - reach), last = smaller_i(count, k + reach + 1);
        const float limit = guard * sorted_middle(blocks + first, last - first, nearby);
        float *part = level + k * SAMPLES_OF_BLOCK;
        const int64_t columns = smaller_i(SAMPLES_OF_BLOCK, samples - k * SAMPLES_OF_BLOCK);
        for (int64_t j = 0; j < columns; j++)
            part[j] = smaller_f(limit, part[j]);
    }
}

#endif
