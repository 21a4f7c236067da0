/* What all of this folder looks at: one region of an image, and where its cells lie. */

#ifndef ODS_MEASURE_REGION_H
#define ODS_MEASURE_REGION_H

#include "kernel.h"
#include "ods/pipeline/image/fan.h"
#include "ods/pipeline/image/regions.h"

/* Full width at half its level of a Gaussian in units of its standard deviation. */
#define FULL_WIDTH sqrt(log(256.0))

typedef struct {
    const float *image; /* (beams, columns) */
    int64_t beams, columns;
    const Run *runs; /* by beam, then column */
    int64_t count;
    int64_t low, high;   /* its outermost beams */
    int64_t first, stop; /* its nearest column, and the one behind its farthest */
} Region;

/* Tells whether a region has runs, and all of them lie within the image; notes how far they reach. */
static inline bool is_within(Region *region)
{
    if (region->count == 0)
        return false;
    region->low = region->runs[0].beam, region->high = region->runs[region->count - 1].beam;
    region->first = region->columns, region->stop = 0;
    bool within = region->low >= 0 && region->high < region->beams;
    for (int64_t i = 0; i < region->count; i++) {
        const Run run = region->runs[i];
        within &= region->low <= run.beam && run.beam <= region->high;
        within &= 0 <= run.first && run.first < run.stop && run.stop <= region->columns;
        region->first = smaller_i(region->first, run.first), region->stop = larger_i(region->stop, run.stop);
    }
    return within;
}

static inline const float *row_of(const Region *region, int64_t beam)
{
    return region->image + beam * region->columns;
}

/* Returns a value, or the limit that it is beyond; NaN stays NaN. */
static inline double held(double value, double least, double most)
{
    return value < least ? least : value > most ? most : value;
}

#endif
