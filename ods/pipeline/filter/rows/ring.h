/* The rows around the present one of an image, which is filtered row by row. */

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

#endif
