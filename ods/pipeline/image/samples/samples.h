/* Recorded samples of any type as float32: uint8 and uint16 exactly. */

#ifndef ODS_SAMPLES_H
#define ODS_SAMPLES_H

#include "kernel.h"

/* What an argument `u1|u2|f4` of a kernel is, to be read row by row. */
typedef struct {
    const char *data;
    int64_t row_bytes, samples;
    char type;
} Samples;

#define SAMPLES(k) ((Samples){arguments[k].data, STRIDE(k) * sample_bytes(TYPE(k)), SIZE(k, 1), TYPE(k)})

/* Samples that are judged together. */
#define SAMPLES_OF_BLOCK 32

/* What samples mean, by `SampleScale` of amplitude.py. */
typedef struct {
    double top;        /* full scale */
    double db_a_count; /* what a count is worth where counts are logarithms; 0 where they are not */
} Meaning;

#define MEANING "float top, float db_a_count"
#define MEANING_AT(k) ((Meaning){FLOAT(k), FLOAT((k) + 1)})

static inline int64_t sample_bytes(char type)
{
    return type == 'B' ? 1 : type == 'H' ? 2 : 4;
}

/* Fills out with `count` samples of a row from `first` on, each `step` apart. */
static inline void load_samples(Samples samples, int64_t row, int64_t first, int64_t step, int64_t count, float *restrict out)
{
    const char *begin = samples.data + row * samples.row_bytes;
#define LOAD(TYPE)                                                                                                     \
    {                                                                                                                  \
        const TYPE *restrict source = (const TYPE *)begin + first;                                                     \
        if (step == 1)                                                                                                 \
            for (int64_t j = 0; j < count; j++)                                                                        \
                out[j] = (float)source[j];                                                                             \
        else                                                                                                           \
            for (int64_t j = 0; j < count; j++)                                                                        \
                out[j] = (float)source[step * j];                                                                      \
        break;                                                                                                         \
    }
    switch (samples.type) {
    case 'B':
        LOAD(uint8_t)
    case 'H':
        LOAD(uint16_t)
    default:
        LOAD(float)
    }
#undef LOAD
}

#endif
