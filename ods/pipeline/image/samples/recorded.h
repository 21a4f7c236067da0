/* The recorded samples that an image was made of (`Recorded` of recorded.py). */

#ifndef ODS_RECORDED_H
#define ODS_RECORDED_H

#include "kernel.h"
#include "ods/pipeline/image/missing/no_data.h"
#include "ods/pipeline/image/regions.h"
#include "ods/pipeline/image/samples/samples.h"

/* Column j of the image was made of the `stride` samples from origin[j] on. */
typedef struct {
    int64_t beams, columns;
    Samples samples; /* (beams, samples) of the beams of the image, as they were recorded */
    const int64_t *origin;
    int64_t stride;
    Missing missing;
} Recorded;

/* What a kernel's signature says of it; the image is [beams,columns]. */
#define RECORDED "rows u1|u2|f4[beams,:] recorded, i8[columns] origin, int stride, " MISSING

/* arguments: from its first one on. */
static inline Recorded recorded_at(const Argument *arguments)
{
    return (Recorded){SIZE(0, 0), SIZE(1, 0), SAMPLES(0), ARRAY(const int64_t, 1), INT(2),
                      missing_at(&arguments[3], SIZE(0, 0), SIZE(0, 1))};
}

/* Returns which samples of its beam the cells of a run were made of. */
static inline Span samples_of(Recorded recorded, Run run)
{
    return (Span){larger_i(recorded.origin[run.first], 0),
                  smaller_i(recorded.origin[run.stop - 1] + recorded.stride, recorded.samples.samples)};
}

/* Returns the highest sample of a run; -INFINITY where there is none. */
static inline double highest_sample(Recorded recorded, Run run)
{
    const Span span = samples_of(recorded, run);
    const char *row = recorded.samples.data + run.beam * recorded.samples.row_bytes;
    double highest = -INFINITY;
#define HIGHEST(TYPE)                                                                                                  \
    for (int64_t j = span.begin; j < span.stop; j++)                                                                   \
        highest = larger(((const TYPE *)row)[j], highest);                                                             \
    break;
    switch (recorded.samples.type) {
    case 'B':
        HIGHEST(uint8_t)
    case 'H':
        HIGHEST(uint16_t)
    default:
        HIGHEST(float)
    }
#undef HIGHEST
    return highest;
}

#endif
