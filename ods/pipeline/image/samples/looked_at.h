/* Some samples of a frame, evenly spread: what is known of an image without looking at all of it. */

#ifndef ODS_LOOKED_AT_H
#define ODS_LOOKED_AT_H

#include "ods/pipeline/image/missing/no_data.h"
#include "ods/pipeline/image/samples/samples.h"

/* So many: a share is known to a hundredth or two then. */
#define LOOKED_AT 1024

typedef struct {
    const float *values;
    int64_t count;
} LookedAt;

/* Returns about `count` of the samples of all beams from column `first` on; only such as hold data, where `missing` is
   not NULL. */
static inline LookedAt look_at(Samples frame, int64_t beams, int64_t first, int64_t count, const Missing *missing)
{
    const int64_t samples = larger_i(frame.samples - first, 0);
    const int64_t step = larger_i(1, beams * samples / count) | 1; /* odd: so that it falls in with no rows */
    float *values = SCRATCH(float, beams * samples / step + 1);
    int64_t kept = 0, begin = 0;
    for (int64_t b = 0; b < beams && samples > 0; b++) {
        const int64_t here = begin < samples ? (samples - begin + step - 1) / step : 0, before = kept;
        load_samples(frame, b, first + begin, step, here, values + kept);
        kept += here;
        if (missing != NULL && missing->marks != NULL) {
            kept = before;
            for (int64_t i = 0; i < here; i++)
                if (!is_missing(*missing, b, first + begin + i * step))
                    values[kept++] = values[before + i];
        }
        begin += here * step - samples;
    }
    return (LookedAt){values, kept};
}

#endif
