/* Median along the beam by sorting networks, and across; the image is mirrored at the range ends and the fan's edges.

   Of other nestings of the same minima and maxima gcc makes ten instructions where of these it makes one. */

#include "ods/pipeline/filter/rows/ring.h"
#include "ods/pipeline/image/gained_image.h"

/* Longest window. */
#define MOST 9

/* Triples of samples, each sorted. */
typedef struct {
    float low[COLUMNS + MOST - 3], middle[COLUMNS + MOST - 3], high[COLUMNS + MOST - 3];
} Triples;

static inline float middle(float a, float b, float c)
{
    return larger_f(smaller_f(a, b), smaller_f(larger_f(a, b), c));
}

static void median_of_3_rows(const float *restrict a, const float *restrict b, const float *restrict c, int64_t count,
                             float *restrict out)
{
    for (int64_t j = 0; j < count; j++)
        out[j] = middle(a[j], b[j], c[j]);
}

/* Of two pairs, the lower of the lower ends and the higher of the higher ends cannot be the median. */
static void median_of_5_rows(const float *restrict a, const float *restrict b, const float *restrict c,
                             const float *restrict d, const float *restrict e, int64_t count, float *restrict out)
{
    for (int64_t j = 0; j < count; j++) {
        const float lower = larger_f(smaller_f(a[j], b[j]), smaller_f(c[j], d[j]));
        const float higher = smaller_f(larger_f(a[j], b[j]), larger_f(c[j], d[j]));
        out[j] = middle(lower, higher, e[j]);
    }
}

/* Sorts row[j : j + 3] for j < count: neighbouring windows share these triples. */
static void sort_triples(const float *restrict row, int64_t count, Triples *restrict sorted)
{
    for (int64_t j = 0; j < count; j++) {
        const float lower = smaller_f(row[j], row[j + 1]), higher = larger_f(row[j], row[j + 1]);
        const float rest = larger_f(lower, row[j + 2]);
        sorted->low[j] = smaller_f(lower, row[j + 2]);
        sorted->middle[j] = smaller_f(higher, rest);
        sorted->high[j] = larger_f(higher, rest);
    }
}

/* Of two sorted triples, the third and the fourth value bracket the median of the triples and one more. */
static void median_of_7(const float *restrict row, int64_t count, float *restrict out)
{
    Triples sorted;
    sort_triples(row, count + 3, &sorted);
    const float *a = sorted.low, *b = sorted.middle, *c = sorted.high;
    for (int64_t j = 0; j < count; j++) {
        const float third = smaller_f(smaller_f(c[j], c[j + 3]),
                                      smaller_f(larger_f(a[j], b[j + 3]), larger_f(b[j], a[j + 3])));
        const float fourth = larger_f(larger_f(a[j], a[j + 3]),
                                      larger_f(smaller_f(c[j], b[j + 3]), smaller_f(b[j], c[j + 3])));
        out[j] = middle(third, fourth, row[j + 6]);
    }
}

/* Of three sorted triples: the middle of the highest low, the middle middle and the lowest high value. */
static void median_of_9(const float *restrict row, int64_t count, float *restrict out)
{
    Triples sorted;
    sort_triples(row, count + 6, &sorted);
    const float *a = sorted.low, *b = sorted.middle, *c = sorted.high;
    for (int64_t j = 0; j < count; j++) {
        const float highest_low = larger_f(larger_f(a[j], a[j + 3]), a[j + 6]);
        const float lowest_high = smaller_f(smaller_f(c[j], c[j + 3]), c[j + 6]);
        out[j] = middle(highest_low, middle(b[j], b[j + 3], b[j + 6]), lowest_high);
    }
}

/* Fills out (samples,) with the median over `window`, 3 to 9, of one mirrored row (samples + window - 1,). */
static void median_row(const float *restrict padded, int64_t window, int64_t samples, float *restrict out)
{
    for (int64_t j = 0; j < samples; j += COLUMNS) {
        const float *row = padded + j;
        const int64_t count = smaller_i(COLUMNS, samples - j);
        if (window == 3)
            median_of_3_rows(row, row + 1, row + 2, count, out + j);
        else if (window == 5)
            median_of_5_rows(row, row + 1, row + 2, row + 3, row + 4, count, out + j);
        else if (window == 7)
            median_of_7(row, count, out + j);
        else
            median_of_9(row, count, out + j);
    }
}

/* Fills out with the median of the image over `window` (3, 5, 7, 9) range samples, of these over 1, 3 or 5 beams. */
KERNEL(median_filter, GAINED_IMAGE ", int window, int beams_of_window, out f4[beams,samples] out")
{
    const GainedImage image = gained_image_at(arguments);
    const int64_t window = INT(arguments_of(GAINED_IMAGE)), reach = INT(arguments_of(GAINED_IMAGE) + 1) / 2;
    float *out = ARRAY(float, arguments_of(GAINED_IMAGE) + 2);
    const int64_t beams = image.beams, samples = image.samples;
    float *padded = SCRATCH(float, samples + MOST - 1);
    const Ring ring = new_ring(reach, beams, samples);
    for (int64_t b = 0; b < beams + reach; b++) {
        float *target = out + larger_i(0, b - reach) * samples;
        if (b < beams) {
            load_mirrored(image, b, window / 2, padded);
            median_row(padded, window, samples, reach == 0 ? target : row_of_ring(&ring, b));
        }
        if (b < reach || reach == 0)
            continue;
        const float *const *row = rows_around(&ring, b - reach);
        if (reach == 1)
            median_of_3_rows(row[-1], row[0], row[1], samples, target);
        else
            median_of_5_rows(row[-2], row[-1], row[0], row[1], row[2], samples, target);
    }
}
