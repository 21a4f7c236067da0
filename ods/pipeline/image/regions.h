/* Connected regions of an image, as runs of cells along the beams (`Runs` of regions.py). */

#ifndef ODS_REGIONS_H
#define ODS_REGIONS_H

#include "kernel.h"

/* Neighbouring cells of one beam: columns `first` to `stop` - 1. Regions are numbered from 1. In a signature:
   r16[runs] runs. */
typedef struct {
    int32_t beam, first, stop, region;
} Run;

/* How many runs, and of how many regions. */
typedef struct {
    int64_t runs, regions;
} RunCount;

/* Fills out (count,) with the runs of the wanted regions, wanted (total,), numbered anew without a gap. Runs of regions
   beyond `total` are left out. out may be `runs`. */
static inline RunCount chosen_runs(const Run *runs, int64_t count, const bool *wanted, int64_t total, Run *out)
{
    int32_t *number = SCRATCH(int32_t, total);
    RunCount kept = {0, 0};
    for (int64_t k = 0; k < total; k++)
        number[k] = wanted[k] ? (int32_t)++kept.regions : 0;
    for (int64_t i = 0; i < count; i++) {
        const int32_t region = runs[i].region;
        if (region >= 1 && region <= total && wanted[region - 1]) {
            out[kept.runs] = runs[i];
            out[kept.runs++].region = number[region - 1];
        }
    }
    return kept;
}

static inline int64_t order_of_run(Run run)
{
    return ((int64_t)run.region << 32) + ((int64_t)run.beam << 17) + run.first; /* of 32768 beams, 131072 samples */
}

/* Fills out with the runs of numbered regions (not 0), by region, beam and column; returns how many. */
int64_t sorted_runs(const Run *runs, int64_t count, Run *out);

#endif
