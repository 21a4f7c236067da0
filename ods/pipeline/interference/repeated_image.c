/* What of an image no later one can have again: the signs of differences of neighbouring samples (repeated_image.py). */

#include "ods/pipeline/image/samples/samples.h"

/* Places that are looked at, spread over the image, and differences at each, one a bit. */
#define PLACES 128
#define DIFFERENCES 8
#define WORDS (PLACES * DIFFERENCES / 64)
/* So many differences have to be none of nothing. */
#define FEWEST 128

/* Bits of the differences that rise, and of those that fall. */
typedef struct {
    uint64_t rising[WORDS], falling[WORDS];
} Signs;

static Signs signs_of(Samples frame, int64_t beams)
{
    Signs signs = {{0}, {0}};
    const int64_t places = larger_i(frame.samples - DIFFERENCES, 1);
    float values[DIFFERENCES + 1];
    for (uint32_t k = 0; k < PLACES && frame.samples > DIFFERENCES; k++) {
        const int64_t column = (int64_t)((k * 0x9E3779B1u) >> 8) % places; /* anywhere, but always the same */
        load_samples(frame, k * beams / PLACES, column, 1, DIFFERENCES + 1, values);
        for (uint32_t j = 0; j < DIFFERENCES; j++) {
            const uint32_t bit = k * DIFFERENCES + j;
            signs.rising[bit / 64] |= (uint64_t)(values[j + 1] > values[j]) << bit % 64;
            signs.falling[bit / 64] |= (uint64_t)(values[j + 1] < values[j]) << bit % 64;
        }
    }
    return signs;
}

/* Returns the correlation of two images' signs; 0 where they have too few. */
static double correlation(const Signs *a, const Signs *b)
{
    int32_t alike = 0, other = 0, any = 0;
    for (int64_t w = 0; w < WORDS; w++) {
        alike += __builtin_popcountll(a->rising[w] & b->rising[w]) + __builtin_popcountll(a->falling[w] & b->falling[w]);
        other += __builtin_popcountll(a->rising[w] & b->falling[w]) + __builtin_popcountll(a->falling[w] & b->rising[w]);
        any += __builtin_popcountll(a->rising[w] | a->falling[w] | b->rising[w] | b->falling[w]);
    }
    return any < FEWEST ? 0.0 : (double)(alike - other) / any;
}

/* Fills signs with those of a frame; returns the first of the known ones that they are like, by a correlation of `least`
   or more, -1 if there is none. */
KERNEL_INT(find_alike, "rows u1|u2|f4[beams,:] frame, i8[known,32] known, float least, out i8[32] signs")
{
    const Signs signs = signs_of(SAMPLES(0), SIZE(0, 0)), *known = ARRAY(const Signs, 1);
    memcpy(ARRAY(Signs, 3), &signs, sizeof signs);
    for (int64_t k = 0; k < SIZE(1, 0); k++)
        if (correlation(&signs, known + k) >= FLOAT(2))
            return k;
    return -1;
}
