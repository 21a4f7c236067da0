/* How sharply an echo sets in: a body's face is met at once, what shines of a rough bottom grows and fades. */

#ifndef ODS_ONSET_H
#define ODS_ONSET_H

#include "ods/pipeline/measure/region.h"

/* Returns how far the echo's highest level lies behind the place before it that has half of that, in its beam.

   In units of `point`, the width of a point, columns (0: not known), whatever the levels of detection. Returns 0 where
   that is not known, or the image or its data begin later. */
static inline double onset_of_region(const Region *region, double point)
{
    const float *row = row_of(region, region->low);
    int64_t peak = region->runs[0].first;
    for (int64_t i = 0; i < region->count; i++) {
        const Run run = region->runs[i];
        const float *other = row_of(region, run.beam);
        for (int64_t j = run.first; j < run.stop; j++)
            if (other[j] > row[peak])
                row = other, peak = j;
    }
    const float half = 0.5f * row[peak];
    int64_t last = peak;
    while (last > 0 && row[last - 1] >= half)
        last--;
    if (!(point > 0.0) || last == 0 || row[last - 1] <= 0.0f)
        return 0.0;
    const float part = (row[last] - half) / (row[last] - row[last - 1]);
    return ((double)(peak - last) + part) / point;
}

#endif
