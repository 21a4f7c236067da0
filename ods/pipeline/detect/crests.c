/* How high the background's crests reach, region by region: maxima of the tiles of an image, and their quantiles. */

#include "ods/pipeline/detect/inside.h"
#include "ods/pipeline/filter/lanes.h"

/* Of the histograms of maxima, in multiples of the noise. */
#define BIN 0.1
/* Fewer tiles, in a region and those around it, tell nothing. */
#define LEAST_TILES 32
/* The two quantiles. An object fills few tiles and cannot move them far. */
#define MIDDLE 0.5
#define UPPER 0.9
/* Maxima more than so many times as far over the background as the middle one are objects: a wall fills a tenth. */
#define TOO_HIGH 2.5

typedef int32_t Bits __attribute__((vector_size(32))); /* of Lanes */

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

/* Returns which is higher, lane by lane. */
static inline Lanes higher(Lanes a, Lanes b)
{
    const Bits above = a > b;
    return (Lanes)((above & (Bits)a) | (~above & (Bits)b));
}

/* Returns the highest of some cells, which are 0 at least. */
static float highest_of(const float *cells, int64_t count)
{
    float highest = 0.0f;
    if (count >= LANES) {
        Lanes lanes = load(cells + count - LANES);
        for (int64_t j = 0; j + LANES < count; j += LANES)
            lanes = higher(load(cells + j), lanes);
        for (int k = 0; k < LANES; k++)
            highest = larger_f(lanes[k], highest);
    } else
        for (int64_t j = 0; j < count; j++)
            highest = larger_f(cells[j], highest);
    return highest;
}

/* Adds the maxima of tiles, of `tile` columns each, to a histogram of multiples of `bin` over the background.
   Tiles whose cells are all 0 hold no data and do not count. */
static void add_crests(const float *highest, int64_t columns, int64_t tile, double background, double bin, int64_t bins,
                       int32_t *histogram)
{
    for (int64_t begin = 0; begin < columns; begin += tile) {
        const float crest = highest_of(highest + begin, smaller_i(tile, columns - begin));
        const double place = larger((crest - background) / bin, 0.0);
        if (crest > 0.0f)
            histogram[(int64_t)smaller(place, (double)(bins - 1))]++;
    }
}

/* Fills histograms with the tiles' maxima of each region, `region` tiles along each side, over the background. */
KERNEL(count_maxima, "f4[beams,samples] image, int tile_beams, int tile_samples, int region, float background, "
                     "float noise, out i4[rows,columns,bins] histograms")
{
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1), bins = SIZE(6, 2);
    const int64_t tile_beams = larger_i(INT(1), 1), tile = larger_i(INT(2), 1), region = larger_i(INT(3), 1);
    const int64_t columns = SIZE(6, 1), across = tile_beams * region, along = tile * region;
    int32_t *histograms = ARRAY(int32_t, 6);
    float *highest = SCRATCH(float, samples);
    memset(histograms, 0, (size_t)(SIZE(6, 0) * columns * bins) * sizeof *histograms);
    if (SIZE(6, 0) * across < beams || columns * along < samples || bins == 0)
        return; /* regions would lie beyond the histograms */
    for (int64_t first = 0; first < beams; first += tile_beams) {
        int32_t *row = histograms + first / across * columns * bins;
        const float *image = ARRAY(const float, 0) + first * samples;
        highest_of_beams(image, smaller_i(tile_beams, beams - first), samples, highest);
        for (int64_t begin = 0; begin < samples; begin += along, row += bins)
            add_crests(highest + begin, smaller_i(along, samples - begin), tile, FLOAT(4), FLOAT(5) * BIN, bins, row);
    }
}

/* Adds count numbers to those of `out`. */
static void add(const int32_t *restrict numbers, int64_t count, int32_t *restrict out)
{
    for (int64_t k = 0; k < count; k++)
        out[k] += numbers[k];
}

static int64_t sum(const int32_t *histogram, int64_t bins)
{
    int32_t total = 0;
    for (int64_t k = 0; k < bins; k++)
        total += histogram[k];
    return total;
}

/* Returns the quantile of what is in the first bins, in bins, interpolated. */
static double quantile(const int32_t *histogram, double share, int64_t bins)
{
    const double rank = share * (double)sum(histogram, bins);
    const int64_t wanted = (int64_t)ceil(rank);
    int64_t below = 0, k = 0;
    while (k < bins && below + histogram[k] < wanted)
        below += histogram[k++];
    return k < bins ? (double)k + (rank - (double)below) / (double)larger_i(histogram[k], 1) : (double)bins;
}

/* Fills out (2,) with the two quantiles, (0, 0) where tiles are few. */
static void two_quantiles(const int32_t *histogram, int64_t bins, double *out)
{
    out[0] = out[1] = 0.0;
    if (sum(histogram, bins) < LEAST_TILES)
        return;
    const double middle = quantile(histogram, MIDDLE, bins);
    out[0] = BIN * middle;
    out[1] = BIN * quantile(histogram, UPPER, smaller_i(bins, (int64_t)(TOO_HIGH * middle) + 1));
}

/* Fills out with the two quantiles of each region and those around it; (0, 0) where tiles are few. */
KERNEL(quantiles_around, "i4[rows,columns,bins] histograms, out f8[rows,columns,2] out")
{
    const int64_t rows = SIZE(0, 0), columns = SIZE(0, 1), bins = SIZE(0, 2), row = columns * bins;
    double *out = ARRAY(double, 1);
    int32_t *across = SCRATCH(int32_t, row), *around = SCRATCH(int32_t, bins);
    for (int64_t i = 0; i < rows; i++) {
        memset(across, 0, (size_t)row * sizeof *across);
        for (int64_t near = larger_i(i - 1, 0); near < smaller_i(i + 2, rows); near++)
            add(ARRAY(const int32_t, 0) + near * row, row, across);
        for (int64_t j = 0; j < columns; j++, out += 2) {
            memset(around, 0, (size_t)bins * sizeof *around);
            for (int64_t beside = larger_i(j - 1, 0); beside < smaller_i(j + 2, columns); beside++)
                add(across + beside * bins, bins, around);
            two_quantiles(around, bins, out);
        }
    }
}

/* Returns which of `count` places, `size` beams or samples each, holds one. */
static int64_t place_of(int64_t index, int64_t size, int64_t count)
{
    return smaller_i(index / larger_i(size, 1), count - 1);
}

/* Fills out with background + (image - background) * the factor of the place, of so many beams and samples. */
KERNEL(shrink, "f4[beams,samples] image, float background, f4[rows,columns] factors, int place_beams, "
               "int place_samples, out f4[beams,samples] out")
{
    const int64_t samples = SIZE(0, 1), rows = SIZE(2, 0), columns = SIZE(2, 1);
    const float background = (float)FLOAT(1);
    float *restrict along = SCRATCH(float, samples);
    int64_t row = -1;
    for (int64_t b = 0; b < SIZE(0, 0) && rows * columns > 0; b++) {
        const float *restrict cells = ARRAY(const float, 0) + b * samples;
        float *restrict out = ARRAY(float, 5) + b * samples;
        if (row != place_of(b, INT(3), rows)) {
            row = place_of(b, INT(3), rows);
            for (int64_t j = 0; j < samples; j++)
                along[j] = ARRAY(const float, 2)[row * columns + place_of(j, INT(4), columns)];
        }
        for (int64_t j = 0; j < samples; j++) {
            const float shrunk = background + (cells[j] - background) * along[j];
            out[j] = along[j] == 1.0f ? cells[j] : shrunk;
        }
    }
}

/* Tells which regions of runs have a cell above the level of its place in the image, of so many beams and samples. */
KERNEL(reaching, "f4[beams,samples] image, r16[runs] runs, f4[rows,columns] levels, int place_beams, "
                 "int place_samples, out b1[regions] found")
{
    const int64_t samples = SIZE(0, 1), rows = SIZE(2, 0), columns = SIZE(2, 1), regions = SIZE(5, 0);
    const Run *runs = ARRAY(const Run, 1);
    bool *found = ARRAY(bool, 5);
    memset(found, 0, (size_t)regions);
    for (int64_t i = 0; i < SIZE(1, 0) && rows * columns > 0; i++) {
        if (!lies_inside(runs[i], SIZE(0, 0), samples, regions) || found[runs[i].region - 1])
            continue;
        const float *cells = ARRAY(const float, 0) + runs[i].beam * samples;
        const float *levels = ARRAY(const float, 2) + place_of(runs[i].beam, INT(3), rows) * columns;
        for (int64_t j = runs[i].first; j < runs[i].stop; j++)
            found[runs[i].region - 1] |= cells[j] > levels[place_of(j, INT(4), columns)];
    }
}
