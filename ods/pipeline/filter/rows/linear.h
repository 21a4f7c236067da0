/* What separable filters are made of, and rows weighed from beam to beam. */

#ifndef ODS_LINEAR_H
#define ODS_LINEAR_H

#include "kernel.h"
#include "ods/pipeline/filter/rows/lanes.h"
#include "ods/pipeline/filter/rows/ring.h"

/* A separable symmetric filter: weights from the middle outwards, of sum 1 with their mirror image. */
typedef struct {
    const float *along, *across; /* (half + 1,) along the range, (reach + 1,) from beam to beam */
    int64_t half, reach;
} SeparableFilter;

/* What a kernel's signature says of it, and how many arguments it takes. */
#define SEPARABLE_FILTER "f4[:] along, f4[:] across"

/* arguments: from the filter's first one on. */
static inline SeparableFilter separable_filter_at(const Argument *arguments)
{
    return (SeparableFilter){ARRAY(const float, 0), ARRAY(const float, 1), SIZE(0, 0) - 1, SIZE(1, 0) - 1};
}

/* Fills target (samples,) with the weighted sum of the rows around row b; weights (reach + 1,): from there outwards. */
static inline void weigh_ring(const Ring *ring, const float *weights, int64_t b, float *restrict target)
{
    const float *const *row = rows_around(ring, b);
    for (int64_t j = 0; j < ring->samples; j += BLOCK) {
        Lanes sums[LANES_OF_BLOCK];
        for (int64_t i = 0; i < LANES_OF_BLOCK; i++)
            sums[i] = weights[0] * load(row[0] + j + i * LANES);
        for (int64_t k = 1; k <= ring->reach; k++)
            for (int64_t i = 0; i < LANES_OF_BLOCK; i++)
                sums[i] += weights[k] * (load(row[-k] + j + i * LANES) + load(row[k] + j + i * LANES));
        store_block(sums, ring->samples - j, target + j);
    }
}

#endif
