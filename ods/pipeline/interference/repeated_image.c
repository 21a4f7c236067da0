/* What of an image no later one can have again: the signs of differences of neighbouring samples (repeated_image.py). */

#include "ods/pipeline/image/samples/samples.h"

/* Differences at each place that is looked at, one a bit; the places are spread over the image. */
#define DIFFERENCES 8

/* Bits of the differences that rise, and of those that fall: (words,) each. */
typedef struct {
    uint64_t *rising, *falling;
} Signs;

static Signs signs_at(void *bits, int64_t words) { return (Signs){bits, (uint64_t *)bits + words}; }

/* Fills signs, all 0 before, with those of a frame. */
static void find_signs(Samples frame, int64_t beams, int64_t words, Signs signs)
{
    const int64_t columns = larger_i(frame.samples - DIFFERENCES, 1);
    const uint32_t places = (uint32_t)(64 * words / DIFFERENCES);
    float values[DIFFERENCES + 1];
    for (uint32_t k = 0; k < places && frame.samples > DIFFERENCES; k++) {
        const int64_t column = (int64_t)((k * 0x9E3779B1u) >> 8) % columns; /* anywhere, but always the same */
        load_samples(frame, k * beams / places, column, 1, DIFFERENCES + 1, values);
        for (uint32_t j = 0; j < DIFFERENCES; j++) {
            const uint32_t bit = k * DIFFERENCES + j;
            signs.rising[bit / 64] |= (uint64_t)(values[j + 1] > values[j]) << bit % 64;
            signs.falling[bit / 64] |= (uint64_t)(values[j + 1] < values[j]) << bit % 64;
        }
    }
}

/* Returns the correlation of two images' signs; 0 where they have less than one a place: those may be of nothing. */
static double correlation(Signs a, Signs b, int64_t words)
{
    int64_t alike = 0, other = 0, any = 0;
    for (int64_t w = 0; w < words; w++) {
        alike += __builtin_popcountll(a.rising[w] & b.rising[w]) + __builtin_popcountll(a.falling[w] & b.falling[w]);
        other += __builtin_popcountll(a.rising[w] & b.falling[w]) + __builtin_popcountll(a.falling[w] & b.rising[w]);
        any += __builtin_popcountll(a.rising[w] | a.falling[w] | b.rising[w] | b.falling[w]);
    }
    return any < 64 * words / DIFFERENCES ? 0.0 : (double)(alike - other) / (double)any;
}

/* Fills signs with those of a frame; returns the first of the known ones that they are like, by a correlation of `least`
   or more, -1 if there is none. */
KERNEL_INT(find_alike, "rows u1|u2|f4[beams,:] frame, i8[known,signs] known, float least, out i8[signs] signs")
{
    const int64_t size = SIZE(3, 0), words = size / 2;
    const Signs signs = signs_at(ARRAY(void, 3), words);
    memset(signs.rising, 0, (size_t)size * sizeof *signs.rising);
    find_signs(SAMPLES(0), SIZE(0, 0), words, signs);
    for (int64_t k = 0; k < SIZE(1, 0); k++)
        if (correlation(signs, signs_at(ARRAY(uint64_t, 1) + k * size, words), words) >= FLOAT(2))
            return k;
    return -1;
}
