/* Histograms of the cells of an image where no echo is, and of those where one may be. */

#include "ods/pipeline/image/samples/samples.h"

/* An image whose cells fill fewer bins was recorded in counts of few bits. */
#define FEW 1024

/* Tells whether a cell is above the limit. */
static bool any_above(const float *cells, int64_t count, float limit)
{
    int32_t above = 0;
    for (int64_t j = 0; j < count; j++)
        above |= cells[j] > limit;
    return above != 0;
}

/* Adds cells above 0 to a histogram of bins of 1 / unit, up to number `last`; the bin behind it takes the others. */
static void count_positive(const float *restrict cells, int64_t count, float unit, float last,
                           int32_t *restrict histogram)
{
    int32_t bin[SAMPLES_OF_BLOCK];
    for (int64_t j = 0; j < count; j++) {
        const float place = cells[j] * unit;
        const int32_t inside = (int32_t)(place < last ? larger_f(place, 0.0f) : last);
        bin[j] = place > 0.0f ? inside : (int32_t)last + 1; /* NaN, too */
    }
    for (int64_t j = 0; j < count; j++)
        histogram[bin[j]]++;
}

/* Tells of each block of some beams, and of one block beyond them on each side, whether it has a cell above `limit`:
   loud (stop - first + 2, blocks + 2) is all 0 before. */
static void mark_loud(const float *image, int64_t samples, int64_t first, int64_t stop, float limit, uint8_t *loud)
{
    const int64_t blocks = (samples + SAMPLES_OF_BLOCK - 1) / SAMPLES_OF_BLOCK;
    for (int64_t b = first; b < stop; b++)
        for (int64_t k = 0; k < blocks; k++)
            loud[(b - first + 1) * (blocks + 2) + k + 1] =
                any_above(image + b * samples + k * SAMPLES_OF_BLOCK, smaller_i(SAMPLES_OF_BLOCK, samples - k * SAMPLES_OF_BLOCK), limit);
}

/* Tells whether any of 3 x 3 blocks is loud; near: the first of them, `row` apart from the next beam's. */
static bool any_loud(const uint8_t *near, int64_t row)
{
    int any = 0;
    for (int64_t i = 0; i < 3; i++)
        any |= near[i * row] | near[i * row + 1] | near[i * row + 2];
    return any;
}

/* Adds the cells above 0 of beams `begin` to `end` - 1 to two histograms, `room` apart: those of blocks that are, or
   touch, one with a cell above `crest`, which may be an echo's, to the second one. */
static void count_blocks(const float *image, int64_t beams, int64_t samples, int64_t begin, int64_t end, float crest,
                         float unit, int64_t room, int32_t *histograms)
{
    const int64_t blocks = (samples + SAMPLES_OF_BLOCK - 1) / SAMPLES_OF_BLOCK, row = blocks + 2;
    const int64_t first = larger_i(begin - 1, 0), stop = smaller_i(end + 1, beams);
    uint8_t *loud = ZEROS(uint8_t, (stop - first + 2) * row);
    mark_loud(image, samples, first, stop, crest, loud);
    for (int64_t b = begin; b < end; b++)
        for (int64_t k = 0; k < blocks; k++) {
            const bool is_loud = any_loud(loud + (b - first) * row + k, row);
            count_positive(image + b * samples + k * SAMPLES_OF_BLOCK, smaller_i(SAMPLES_OF_BLOCK, samples - k * SAMPLES_OF_BLOCK), unit,
                           (float)(room - 2), histograms + (is_loud ? room : 0));
        }
}

/* Fills bins with the numbers of those that are in any of two histograms, `room` apart; returns how many. */
static int64_t filled_bins(const int32_t *histograms, int64_t count, int64_t room, int32_t *bins)
{
    int64_t filled = 0;
    for (int64_t k = 0; k < count; k++) {
        bins[filled] = (int32_t)k;
        filled += (histograms[k] | histograms[room + k]) != 0;
    }
    return filled;
}

/* Adds a histogram of which few bins are filled to out, each spread halfway to the next ones: counts of few bits stand
   for all levels there. Else a level could lie only at a count, and be wrong by as much as lies between two of them. */
static void add_spread(const int32_t *histogram, const int32_t *filled, int64_t count, double *restrict out)
{
    double begin = filled[0];
    for (int64_t i = 0; i < count; i++) {
        const double end = i + 1 < count ? 0.5 * (filled[i] + filled[i + 1] + 1.0) : filled[i] + 1.0;
        const double density = histogram[filled[i]] / (end - begin);
        for (int64_t k = (int64_t)begin; (double)k < end; k++)
            out[k] += density * (smaller((double)k + 1.0, end) - larger((double)k, begin));
        begin = end;
    }
}

/* Adds the cells above 0 of beams `begin` to `end` - 1 to two histograms of bins of 1 / unit; the second one has those
   that are near one above `crest`, and may be an echo's. Returns how many are in the first one. */
KERNEL_INT(count_cells, "f4[beams,samples] image, int begin, int end, float crest, float unit, "
                        "out f8[2,bins] histograms")
{
    const int64_t begin = larger_i(INT(1), 0), end = smaller_i(INT(2), SIZE(0, 0)), bins = SIZE(5, 1), room = bins + 1;
    int32_t *counted = ZEROS(int32_t, 2 * room), *filled = SCRATCH(int32_t, room);
    int64_t quiet = 0;
    if (begin >= end || bins == 0)
        return 0;
    count_blocks(ARRAY(const float, 0), SIZE(0, 0), SIZE(0, 1), begin, end, (float)FLOAT(3), (float)FLOAT(4), room,
                 counted);
    const int64_t count = filled_bins(counted, bins, room, filled);
    for (int64_t kind = 0; kind < 2; kind++) {
        double *restrict histogram = ARRAY(double, 5) + kind * bins;
        const int32_t *restrict own = counted + kind * room;
        if (1 < count && count < FEW)
            add_spread(own, filled, count, histogram);
        else
            for (int64_t k = 0; k < bins; k++)
                histogram[k] += own[k];
    }
    for (int64_t k = 0; k < bins; k++)
        quiet += counted[k];
    return quiet;
}
