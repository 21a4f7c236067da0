/* The rows around the present one of an image, which is filtered row by row, and what separable filters make of them. */

#ifndef ODS_RING_H
#define ODS_RING_H

#include "kernel.h"
#include "ods/pipeline/filter/rows/lanes.h"
#include "ods/pipeline/filter/rows/padding.h"

typedef struct {
    float *rows; /* (count, samples): row b lies at slot b % count */
    const float **around;
    int64_t reach, count, beams, samples;
} Ring;

/* Returns a ring of the rows up to `reach` beams to either side. */
static inline Ring new_ring(int64_t reach, int64_t beams, int64_t samples)
{
    const int64_t count = 2 * reach + 1;
    return (Ring){SCRATCH(float, count * samples + BLOCK), SCRATCH(const float *, count), reach, count, beams, samples};
}

/* Returns where row b lies. */
static inline float *row_of_ring(const Ring *ring, int64_t b)
{
    return ring->rows + b % ring->count * ring->samples;
}

/* Returns the rows around row b, mirrored at the fan's edges: [-reach] to [reach], all of which have been written. */
static inline const float *const *rows_around(const Ring *ring, int64_t b)
{
    for (int64_t k = 0; k < ring->count; k++)
        ring->around[k] = row_of_ring(ring, mirrored(b + k - ring->reach, ring->beams));
    return ring->around + ring->reach;
}

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
