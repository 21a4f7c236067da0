/* Recorded samples to linear amplitude, and columns of an image that are means of several samples. */

#include "ods/pipeline/image/samples/samples.h"

/* Columns of an image that are made of a frame's: each of `stride` neighbouring ones, from `first` on (`Decimation` of
   amplitude.py). */
typedef struct {
    int64_t first, stride;
    int64_t begin, columns; /* of the image: from here, so many */
} Decimation;

#define DECIMATION "int first, int stride, int begin, int end"

/* arguments: from its first one on. Columns that the frame or the image do not have are left out. */
static Decimation decimation_at(const Argument *arguments, int64_t samples, int64_t columns)
{
    const int64_t first = larger_i(INT(0), 0), stride = larger_i(INT(1), 1), begin = larger_i(INT(2), 0);
    return (Decimation){first, stride, begin, smaller_i(smaller_i(INT(3), columns) - begin, (samples - first) / stride)};
}

/* Fills target (columns,) with means of `stride` neighbouring amplitudes. */
static void average(const float *restrict source, int64_t stride, int64_t columns, float *restrict target)
{
    const float share = 1.0f / (float)stride;
    if (stride == 1)
        memcpy(target, source, (size_t)columns * sizeof *target);
    else if (stride == 2) /* by itself, as a fixed stride vectorises */
        for (int64_t j = 0; j < columns; j++)
            target[j] = 0.5f * (source[2 * j] + source[2 * j + 1]);
    else
        for (int64_t j = 0; j < columns; j++) {
            float total = 0.0f;
            for (int64_t k = stride * j; k < stride * (j + 1); k++)
                total += source[k];
            target[j] = share * total;
        }
}

/* Fills amplitude (count,) with those of samples of a row from `first` on. table: of each count; NULL: samples are
   linear amplitudes, of which the largest is `most`. */
static void load_amplitudes(Samples frame, int64_t row, int64_t first, int64_t count, const float *restrict table,
                            float most, float *restrict amplitude)
{
    const char *counts = frame.data + row * frame.row_bytes;
    if (table == NULL) {
        load_samples(frame, row, first, 1, count, amplitude);
        for (int64_t j = 0; j < count; j++)
            amplitude[j] = smaller_f(larger_f(amplitude[j], 0.0f), most);
    } else if (frame.type == 'B')
        for (int64_t j = 0; j < count; j++)
            amplitude[j] = table[((const uint8_t *)counts)[first + j]];
    else
        for (int64_t j = 0; j < count; j++)
            amplitude[j] = table[((const uint16_t *)counts)[first + j]];
}

/* Fills columns of out with the mean amplitude of those of frame; table, most: as above, the table may be empty. */
KERNEL(mean_amplitudes, "rows u1|u2|f4[beams,:] frame, " DECIMATION ", f4[:] table, float most, rows out f4[beams,:] out")
{
    const Samples frame = SAMPLES(0);
    const Decimation part = decimation_at(arguments + 1, SIZE(0, 1), SIZE(7, 1));
    const int64_t count = larger_i(part.columns, 0) * part.stride, counts = SIZE(5, 0);
    const bool fits = counts == 0 || (frame.type != 'f' && counts == 1 << 8 * sample_bytes(frame.type));
    float *amplitude = SCRATCH(float, count);
    for (int64_t b = 0; b < SIZE(0, 0) && count > 0 && fits; b++) {
        load_amplitudes(frame, b, part.first, count, counts > 0 ? ARRAY(const float, 5) : NULL, (float)FLOAT(6), amplitude);
        average(amplitude, part.stride, part.columns, ARRAY(float, 7) + b * STRIDE(7) + part.begin);
    }
}

/* Fills target with means of `stride` counts, rounded down. PAIR: of two of them; a fixed stride vectorises. */
#define AVERAGE(TYPE, PAIR)                                                                                                  \
    static void average_##TYPE(const TYPE *restrict source, int64_t stride, int64_t columns, TYPE *restrict target)    \
    {                                                                                                                  \
        const float share = 1.0f / (float)stride;                                                                      \
        if (stride == 1)                                                                                               \
            memcpy(target, source, (size_t)columns * sizeof *target);                                                  \
        else if (stride == 2)                                                                                          \
            for (int64_t j = 0; j < columns; j++) {                                                                    \
                PAIR pair;                                                                                             \
                memcpy(&pair, source + 2 * j, sizeof pair);                                                            \
                target[j] = (TYPE)(((pair & (TYPE)-1) + (pair >> (8 * sizeof(TYPE)))) >> 1);                           \
            }                                                                                                          \
        else                                                                                                           \
            for (int64_t j = 0; j < columns; j++) {                                                                    \
                float total = 0.5f; /* clear of whole numbers: rounding never takes it below one */                    \
                for (int64_t k = stride * j; k < stride * (j + 1); k++)                                                \
                    total += (float)source[k];                                                                         \
                target[j] = (TYPE)(total * share);                                                                     \
            }                                                                                                          \
    }
AVERAGE(uint8_t, uint16_t)
AVERAGE(uint16_t, uint32_t)
#undef AVERAGE

/* Fills columns of out with the means of those of frame, rounded down; both of one type. */
KERNEL(average_counts, "rows u1|u2[beams,:] frame, " DECIMATION ", rows out u1|u2[beams,:] out")
{
    const Samples frame = SAMPLES(0), out = SAMPLES(5);
    const Decimation part = decimation_at(arguments + 1, SIZE(0, 1), SIZE(5, 1));
    for (int64_t b = 0; b < SIZE(0, 0) && part.columns > 0 && frame.type == out.type; b++) {
        const char *row = frame.data + b * frame.row_bytes;
        char *target = ARRAY(char, 5) + b * out.row_bytes;
        if (frame.type == 'B')
            average_uint8_t((const uint8_t *)row + part.first, part.stride, part.columns, (uint8_t *)target + part.begin);
        else
            average_uint16_t((const uint16_t *)row + part.first, part.stride, part.columns, (uint16_t *)target + part.begin);
    }
}
