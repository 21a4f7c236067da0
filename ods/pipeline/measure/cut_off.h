/* Echoes of which a part may lie where nothing is seen: beyond the fan's beams or ranges, or in beams without data. */

#ifndef ODS_CUT_OFF_H
#define ODS_CUT_OFF_H

#include "ods/pipeline/image/samples/recorded.h"
#include "ods/pipeline/measure/echo.h"
#include "ods/pipeline/measure/circle/enclosing_circle.h"
#include "ods/pipeline/measure/region.h"

/* Standard deviation of the place of an object of which a part is hidden. */
#define HIDDEN_M 5.0
/* Likewise along the range: of what the first or last range cuts off a middle is seen. */
#define BEHIND_M 1.5

/* Returns how many of the cells of a beam beside a run nobody sees. */
static inline int64_t unseen_cells(Recorded recorded, int64_t beam, Run run)
{
    int64_t count = 0;
    for (int64_t j = run.first; j < run.stop; j++) {
        const int64_t column = recorded.origin[j];
        count += is_missing(recorded.missing, beam, column) && !is_one_beam_wide(recorded.missing, beam, column);
    }
    return count;
}

/* Tells whether an echo reaches the fan's edge or beams without data; those that its neighbours fill are seen. */
static inline bool is_cut_beside(Recorded recorded, const Region *region)
{
    if (region->low == 0 || region->high == region->beams - 1)
        return true;
    for (int64_t i = 0; i < region->count && recorded.missing.marks != NULL; i++) {
        const Run run = region->runs[i];
        for (int64_t beam = run.beam - 1; beam <= run.beam + 1; beam += 2)
            if (2 * unseen_cells(recorded, beam, run) > run.stop - run.first)
                return true;
    }
    return false;
}

/* Tells whether an echo reaches the nearest or the farthest range of the image. */
static inline bool is_cut_in_range(const Region *region)
{
    return region->first == 0 || region->stop == region->columns;
}

/* Widens the standard deviations of an echo that is cut off beside, in range, or both.

   How far the object goes on nobody knows, and the error stays the same from ping to ping. What is cut beside shows
   its nearest point or one not much farther, so half as much at most along the range; of what is cut in range the middle is seen. */
static inline void widen(Echo *echo, bool beside, bool in_range)
{
    echo->sigma_range_m = distance_of(echo->sigma_range_m, in_range ? BEHIND_M : smaller(echo->radius_m, 0.5 * HIDDEN_M));
    if (beside)
        echo->sigma_bearing_rad = distance_of(echo->sigma_bearing_rad, HIDDEN_M / larger(HIDDEN_M, echo->range_m));
    echo->sigma_radius_m = distance_of(echo->sigma_radius_m, HIDDEN_M);
}

#endif
