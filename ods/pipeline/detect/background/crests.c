/* How high the background's crests reach, region by region: maxima of the tiles of an image, and their quantiles. */

#include "ods/pipeline/filter/rows/lanes.h"

/* Histograms of maxima: their bins, in multiples of the noise. */
#define BINS 320
#define BIN 0.1
/* The two quantiles. An object fills few tiles and cannot move them far. */
#define MIDDLE 0.5
#define UPPER 0.9
/* Maxima more than so many times as far over the background as the middle one are objects: a wall fills a tenth. */
#define TOO_HIGH 2.5
/* Regions of speckle itself differ by so much: 19 of 20 by less. */
#define BY_CHANCE 1.12

typedef uint16_t Count; /* of tiles */

/* Fills out with the highest cell of some beams at each sample, at least 0. */
static void highest_of_beams(const float *image, int64_t beams, int64_t samples, float *restrict out)
{
    for (int64_t j = 0; j < samples; j++)
        out[j] = larger_f(image[j], 0.0f);
    for (int64_t b = 1; b < beams; b += 2) { /* whole rows, two by two: that vectorises */
        const float *restrict one = image + b * samples, *restrict other = b + 1 < beams ? one + samples : one;
        for (int64_t j = 0; j < samples; j++)
            out[j] = larger_f(one[j], larger_f(other[j], out[j]));
    }
}

/* Returns the highest of some cells, which are 0 at least. */
static float highest_of(const float *cells, int64_t count)
{
    float highest = 0.0f;
    if (count >= LANES) {
        Lanes lanes = load(cells + count - LANES);
        for (int64_t j = 0; j + LANES < count; j += LANES)
            lanes = higher(load(cells + j), lanes);
        highest = larger_f(highest_lane(lanes), highest);
    } else
        for (int64_t j = 0; j < count; j++)
            highest = larger_f(cells[j], highest);
    return highest;
}

/* Adds the maxima of tiles, of `tile` columns each, to a histogram of multiples of `bin` over the background.
   Tiles whose cells are all 0 hold no data and do not count. */
static void add_crests(const float *highest, int64_t columns, int64_t tile, double background, double bin,
                       Count *histogram)
{
    for (int64_t begin = 0; begin < columns; begin += tile) {
        const float crest = highest_of(highest + begin, smaller_i(tile, columns - begin));
        const double place = larger((crest - background) / bin, 0.0);
        if (crest > 0.0f)
            histogram[(int64_t)smaller(place, BINS - 1.0)]++;
    }
}

/* An image (beams, samples), its tiles, its regions (rows, columns), and its levels. */
typedef struct {
    const float *image;
    int64_t beams, samples, tile_beams, tile_samples;
    int64_t region; /* tiles along each side of a region; it is judged with the eight around it */
    int64_t rows, columns;
    double background, noise;
} Crests;

#define CRESTS "f4[beams,samples] image, int tile_beams, int tile_samples, int region, float background, float noise"

/* arguments: from the first one on. */
static Crests crests_at(const Argument *arguments)
{
    const int64_t tile_beams = larger_i(INT(1), 1), tile_samples = larger_i(INT(2), 1);
    const int64_t region = larger_i(INT(3), 1), across = tile_beams * region, along = tile_samples * region;
    return (Crests){ARRAY(const float, 0), SIZE(0, 0), SIZE(0, 1), tile_beams, tile_samples, region,
                    (SIZE(0, 0) + across - 1) / across, (SIZE(0, 1) + along - 1) / along, FLOAT(4), FLOAT(5)};
}

/* Fills histograms (rows, columns, BINS), all 0 before, with the tiles' maxima of each region, over the background. */
static void count_maxima(const Crests *crests, Count *histograms)
{
    const int64_t samples = crests->samples, along = crests->tile_samples * crests->region;
    float *highest = SCRATCH(float, samples);
    for (int64_t first = 0; first < crests->beams; first += crests->tile_beams) {
        Count *row = histograms + first / (crests->tile_beams * crests->region) * crests->columns * BINS;
        highest_of_beams(crests->image + first * samples, smaller_i(crests->tile_beams, crests->beams - first), samples,
                         highest);
        for (int64_t begin = 0; begin < samples; begin += along, row += BINS)
            add_crests(highest + begin, smaller_i(along, samples - begin), crests->tile_samples, crests->background,
                       crests->noise * BIN, row);
    }
}

/* Adds count numbers to those of `out`. */
static void add(const Count *restrict numbers, int64_t count, Count *restrict out)
{
    for (int64_t k = 0; k < count; k++)
        out[k] += numbers[k];
}

static int64_t sum(const Count *histogram, int64_t bins)
{
    int32_t total = 0;
    for (int64_t k = 0; k < bins; k++)
        total += histogram[k];
    return total;
}

/* Returns the quantile of the `total` tiles that are in the first bins, in bins, interpolated. */
static double quantile(const Count *histogram, double share, int64_t bins, int64_t total)
{
    const double rank = share * (double)total;
    const int64_t wanted = (int64_t)ceil(rank);
    int64_t below = 0, k = 0;
    while (k < bins && below + histogram[k] < wanted)
        below += histogram[k++];
    return k < bins ? (double)k + (rank - (double)below) / (double)larger_i(histogram[k], 1) : (double)bins;
}

/* Fills out (2,) with the two quantiles, (0, 0) where there are fewer tiles than `least`. */
static void two_quantiles(const Count *histogram, int64_t least, double *out)
{
    const int64_t total = sum(histogram, BINS);
    out[0] = out[1] = 0.0;
    if (total < least)
        return;
    const double middle = quantile(histogram, MIDDLE, BINS, total);
    const int64_t bins = smaller_i(BINS, (int64_t)(TOO_HIGH * middle) + 1);
    out[0] = BIN * middle;
    out[1] = BIN * quantile(histogram, UPPER, bins, sum(histogram, bins));
}

/* Fills quantiles (rows, columns, 2) with the two of each region and those around it; (0, 0) where tiles are few. */
static void find_quantiles(const Crests *crests, double *quantiles)
{
    const int64_t rows = crests->rows, columns = crests->columns, row = columns * BINS;
    const int64_t least = 2 * crests->region * crests->region; /* fewer than two regions have are no evidence */
    Count *histograms = ZEROS(Count, rows * row), *across = SCRATCH(Count, row), *around = SCRATCH(Count, BINS);
    count_maxima(crests, histograms);
    for (int64_t i = 0; i < rows; i++) {
        memset(across, 0, (size_t)row * sizeof *across);
        for (int64_t near = larger_i(i - 1, 0); near < smaller_i(i + 2, rows); near++)
            add(histograms + near * row, row, across);
        for (int64_t j = 0; j < columns; j++, quantiles += 2) {
            memset(around, 0, BINS * sizeof *around);
            for (int64_t beside = larger_i(j - 1, 0); beside < smaller_i(j + 2, columns); beside++)
                add(across + beside * BINS, BINS, around);
            two_quantiles(around, least, quantiles);
        }
    }
}

/* Fills out with the two quantiles of each region and those around it; (0, 0) where tiles are few. */
KERNEL(crest_quantiles, CRESTS ", out f8[rows,columns,2] out")
{
    const Crests crests = crests_at(arguments);
    arguments += arguments_of(CRESTS);
    if (SIZE(0, 0) == crests.rows && SIZE(0, 1) == crests.columns)
        find_quantiles(&crests, ARRAY(double, 0));
}

/* Fills factors with how many times as high as `level` crests reach in each region: 1 where they are no higher than
   those of speckle, of which the two quantiles are middle and upper. */
KERNEL(crest_factors, CRESTS ", float level, float middle, float upper, out f8[rows,columns] factors")
{
    const Crests crests = crests_at(arguments);
    arguments += arguments_of(CRESTS);
    const double level = FLOAT(0), share = (level - FLOAT(1)) / (FLOAT(2) - FLOAT(1)); /* of the way to the upper one */
    const int64_t count = crests.rows * crests.columns;
    double *factors = ARRAY(double, 3), *quantiles = SCRATCH(double, 2 * count);
    if (SIZE(3, 0) != crests.rows || SIZE(3, 1) != crests.columns)
        return;
    find_quantiles(&crests, quantiles);
    for (int64_t k = 0; k < count; k++) {
        const double factor = ((1.0 - share) * quantiles[2 * k] + share * quantiles[2 * k + 1]) / level;
        factors[k] = factor < BY_CHANCE ? 1.0 : factor;
    }
}
