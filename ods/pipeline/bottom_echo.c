/* Where the bottom's echo sets in, in levels over ratios of ranges (bottom_echo.py). */

#include "ods/pipeline/image/no_data.h"
#include "ods/pipeline/image/samples.h"

#define DB_OF_E 8.685889638065037 /* 20 log10 e; log10 takes three times as long */

/* Bins, from the middle of the rise, of the quiet before it, */
#define QUIET_FROM (-15)
#define QUIET_TO (-5)
/* and of the bottom behind it, */
#define LOUD_FROM 4
#define LOUD_TO 13
/* of which each so many may be */
#define PART 3
#define FEWEST_LOUD 5
/* off their mean by no more; where the image ends, so few do. */
#define UNEVEN_DB 5.0
/* The bottom is louder than the quiet before it by so much at least. */
#define RISE_DB 10.0
/* What is louder than that behind it was no main lobe's. */
#define LOUDER_DB 6.0
/* The edge of the main lobe is so much under the level behind the rise. */
#define EDGE_DB 4.0
/* Bins in which that level is looked for. */
#define SEARCHED 14
#define TURNS 3
/* Bins, from the rise, in which the dip is looked for, */
#define DIP_FROM (-24)
#define DIP_TO (-3)
/* and what side lobes hear before it, louder by */
#define HUMP_FROM (-43)
#define HUMP_TO (-12)
/* so much. Nearer to the rise it may be the echo from straight below, and the rise that of a side lobe. */
#define DIP_DB 1.0
/* A level is that of so many bins on either side, too. */
#define SMOOTH 4

/* Returns the mean level of bins `begin` to `end` - 1. */
static double mean(const double *level, int64_t begin, int64_t end)
{
    double total = 0.0;
    for (int64_t k = begin; k < end; k++)
        total += level[k];
    return total / (double)(end - begin);
}

/* Returns the bin in the middle of the strongest rise, -1 where it is too weak. */
static int64_t strongest_rise(const double *level, int64_t bins)
{
    int64_t best = -1;
    double rise = RISE_DB;
    for (int64_t k = -QUIET_FROM; k < bins - LOUD_FROM - FEWEST_LOUD + 1; k++) {
        const double loud = mean(level, k + LOUD_FROM, smaller_i(k + LOUD_TO, bins));
        const double step = loud - mean(level, k + QUIET_FROM, k + QUIET_TO);
        if (step > rise) {
            best = k;
            rise = step;
        }
    }
    return best;
}

/* Returns the first place before bin `start` where the level, over three bins, is `wanted`; -1: too far away. */
static double down_to(const double *level, int64_t start, double wanted)
{
    double above = NAN;
    for (int64_t k = start; k > larger_i(start - SEARCHED, 0); k--) {
        const double here = mean(level, k - 1, k + 2);
        if (here < wanted)
            return (double)k + (above > here ? (wanted - here) / (above - here) : 0.0);
        above = here;
    }
    return -1.0;
}

/* Tells whether the level behind a rise at bin k is even, and nothing behind it is much louder. */
static bool stays(const double *level, int64_t bins, int64_t k)
{
    const int64_t end = smaller_i(k + LOUD_TO, bins);
    if (end < k + LOUD_FROM + FEWEST_LOUD)
        return false;
    const double loud = mean(level, k + LOUD_FROM, end);
    for (int64_t begin = k + LOUD_FROM; begin < end; begin += PART)
        if (!(fabs(mean(level, begin, smaller_i(begin + PART, end)) - loud) <= UNEVEN_DB))
            return false;
    for (int64_t begin = k + LOUD_TO; begin + LOUD_TO - LOUD_FROM <= bins; begin++)
        if (mean(level, begin, begin + LOUD_TO - LOUD_FROM) > loud + LOUDER_DB)
            return false;
    return true;
}

/* Returns the place, in bins, where a rise comes to EDGE_DB under the level behind it, -1 where that does not stay.
   What is behind begins where that is, so both are found in turns. */
static double edge(const double *level, int64_t bins, int64_t middle)
{
    double place = (double)middle;
    for (int turn = 0; turn < TURNS; turn++) {
        const int64_t k = (int64_t)rint(place);
        if (k + LOUD_FROM + FEWEST_LOUD > bins)
            return -1.0;
        const double loud = mean(level, k + LOUD_FROM, smaller_i(k + LOUD_TO, bins));
        place = down_to(level, k + LOUD_FROM, loud - EDGE_DB);
        if (place < 0.0)
            return -1.0;
    }
    return stays(level, bins, (int64_t)rint(place)) ? place : -1.0;
}

/* Returns the mean level about a bin counted from each group's rise; NaN where there is none. */
static double before(const double *level, int64_t groups, int64_t bins, const double *place, int64_t offset)
{
    double total = 0.0;
    int64_t count = 0;
    for (int64_t g = 0; g < groups; g++) {
        const int64_t first = (int64_t)rint(place[g]) + offset - SMOOTH;
        if (place[g] < 0.0 || first < 0)
            continue;
        for (int64_t k = first; k < smaller_i(first + 2 * SMOOTH + 1, bins); k++)
            if (!isnan(level[g * bins + k])) {
                total += level[g * bins + k];
                count++;
            }
    }
    return count > 0 ? total / (double)count : NAN;
}

/* Tells whether the groups, on average, hear less shortly before the rise than farther before it. */
static bool dips(const double *level, int64_t groups, int64_t bins, const double *place)
{
    double low = INFINITY, hump = -INFINITY;
    int64_t dip = 0;
    for (int64_t offset = DIP_FROM; offset < DIP_TO; offset++) {
        const double here = before(level, groups, bins, place, offset);
        if (here < low) {
            low = here;
            dip = offset;
        }
    }
    for (int64_t offset = HUMP_FROM; offset < smaller_i(dip, HUMP_TO); offset++)
        hump = larger(before(level, groups, bins, place, offset), hump);
    return hump >= low + DIP_DB;
}

/* Samples that are looked at: a quarter into each bin and a quarter before its end. */
typedef struct {
    Samples samples;
    Missing missing;
    const int64_t *first, *second; /* (bins,) columns, all in the frame */
    int64_t bins;
} LookedAt;

/* Adds what is looked at of beam b, where it holds data, to the sums of the bins. */
static void add_beam(LookedAt at, int64_t b, double *restrict total, double *restrict count)
{
    const char *row = at.samples.data + b * at.samples.row_bytes;
#define ADD(TYPE)                                                                                                      \
    for (int64_t k = 0; k < at.bins; k++) {                                                                            \
        const double first = ((const TYPE *)row)[at.first[k]], second = ((const TYPE *)row)[at.second[k]];             \
        const bool has_first = !is_missing(at.missing, b, at.first[k]);                                                \
        const bool has_second = !is_missing(at.missing, b, at.second[k]);                                              \
        total[k] += (has_first ? first : 0.0) + (has_second ? second : 0.0);                                           \
        count[k] += has_first + has_second;                                                                            \
    }                                                                                                                  \
    break;
    switch (at.samples.type) {
    case 'B':
        ADD(uint8_t)
    case 'H':
        ADD(uint16_t)
    default:
        ADD(float)
    }
#undef ADD
}

/* Fills level (bins,) with that of the mean recorded number of some beams, dB; NaN where it is not known: below
   `least`. db: of a unit, 0: numbers are linear. */
static void levels_of_beams(LookedAt at, int64_t begin, int64_t end, double db, double least, double *restrict level)
{
    double *restrict total = ZEROS(double, at.bins), *restrict count = ZEROS(double, at.bins);
    for (int64_t b = begin; b < end; b++)
        add_beam(at, b, total, count);
    for (int64_t k = 0; k < at.bins; k++) {
        const double value = total[k] / count[k];
        const bool known = value >= least && (value > 0.0 || db > 0.0);
        level[k] = !known ? NAN : db > 0.0 ? db * value : DB_OF_E * log(value);
    }
}

/* Fills place with where, in bins, the bottom's echo sets in for each group of beams, -1 where it is not seen. */
KERNEL(bottom_places, "rows u1|u2|f4[:,:] frame, " MISSING ", i8[:] borders, i8[2,bins] columns, float db, "
                      "float least, out f8[groups] place")
{
    const int64_t beams = SIZE(0, 0), groups = smaller_i(SIZE(6, 0), SIZE(2, 0) - 1), bins = SIZE(3, 1);
    const int64_t *borders = ARRAY(const int64_t, 2);
    const int64_t *columns = ARRAY(const int64_t, 3);
    const LookedAt at = {SAMPLES(0), missing_at(&arguments[1], beams, SIZE(0, 1)), columns, columns + bins, bins};
    double *level = SCRATCH(double, larger_i(groups, 0) * bins), *place = ARRAY(double, 6);
    for (int64_t g = 0; g < SIZE(6, 0); g++)
        place[g] = -1.0;
    for (int64_t k = 0; k < 2 * bins; k++)
        if (columns[k] < 0 || columns[k] >= SIZE(0, 1))
            return;
    for (int64_t g = 0; g < groups; g++) {
        double *own = level + g * bins;
        levels_of_beams(at, larger_i(borders[g], 0), smaller_i(borders[g + 1], beams), FLOAT(4), FLOAT(5), own);
        const int64_t middle = strongest_rise(own, bins);
        place[g] = middle >= 0 ? edge(own, bins, middle) : -1.0;
    }
    if (!dips(level, groups, bins, place))
        for (int64_t g = 0; g < groups; g++)
            place[g] = -1.0;
}
