/* Whether runs lie in the image that they are said to be of. */

#ifndef ODS_INSIDE_H
#define ODS_INSIDE_H

#include "ods/pipeline/image/regions.h"

/* Tells whether a run has cells, all in an image of beams x samples, and a region of 1 to `regions`. */
static inline bool lies_inside(Run run, int64_t beams, int64_t samples, int64_t regions)
{
    return run.beam >= 0 && run.beam < beams && run.first >= 0 && run.first < run.stop && run.stop <= samples
           && run.region >= 1 && run.region <= regions;
}

#endif
