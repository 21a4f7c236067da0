/* An image divided by the level of each cell's surroundings, along the beam (cfar.py). */

#include "ods/pipeline/filter/rows/halving.h"
#include "ods/pipeline/filter/rows/lanes.h"
#include "ods/pipeline/filter/rows/padding.h"

enum method { CA, GOCA, SOCA, OS }; /* places in cfar.py's _METHODS */

/* Least level, in units of the whole image's. */
#define LEAST 0.05f
/* Counts of LANES cells. */
typedef int32_t Counts __attribute__((vector_size(32), aligned(4), may_alias));

/* `CfarWindow` of cfar.py, and what follows. */
typedef struct {
    int64_t method, guard, train;
    double rank;
    int64_t behind; /* from the first cell before a cell that counts to the first one behind it */
    float middle, least;
} Window;

/* The surroundings of a row's cells, with BLOCK more so that all blocks are whole. */
typedef struct {
    float *padded; /* the row, mirrored at its ends: cells from j and from j + behind on surround cell j */
    float *sums;   /* of `train` cells from each one on, */
    float *held;   /* and how many of them hold data: are not 0 */
    float *spare[2];
    int64_t length;
} Row;

/* Fills out with the sums of `width` cells from each one on: added up of sums of 1, 2, 4, ... cells. */
static void window_sums(const float *cells, int64_t width, Row row, float *restrict out)
{
    int64_t done = 0, which = 0;
    memset(out, 0, (size_t)row.length * sizeof *out);
    for (int64_t wide = 1;; wide *= 2) {
        if (width & wide) {
            for (int64_t j = 0; j < row.length - done - wide + 1; j++)
                out[j] += cells[j + done];
            done += wide;
        }
        if (done == width)
            return;
        float *restrict next = row.spare[which];
        for (int64_t j = 0; j < row.length - 2 * wide + 1; j++)
            next[j] = cells[j] + cells[j + wide];
        cells = next;
        which = 1 - which;
    }
}

/* Fills the row with what surrounds the cells of a beam. */
static void surround(const float *cells, int64_t samples, Window window, Row row)
{
    const int64_t reach = window.guard + window.train;
    memcpy(row.padded + reach, cells, (size_t)samples * sizeof *cells);
    mirror_ends(row.padded, reach, samples);
    window_sums(row.padded, window.train, row, row.sums);
    float *restrict holds_data = row.spare[1];
    for (int64_t i = 0; i < row.length; i++)
        holds_data[i] = row.padded[i] == 0.0f ? 0.0f : 1.0f;
    window_sums(holds_data, window.train, row, row.held);
}

/* Fills out with the mean of the surroundings of each cell, or that of one side. */
static void averages(Row row, Window window, int64_t samples, float *restrict out)
{
    const float *restrict near_sum = row.sums, *restrict far_sum = row.sums + window.behind;
    const float *restrict near_count = row.held, *restrict far_count = row.held + window.behind;
    for (int64_t j = 0; j < samples; j++) {
        const float count = near_count[j] + far_count[j];
        const float near = near_sum[j] / near_count[j], far = far_sum[j] / far_count[j];
        const float side = (window.method == GOCA) == (near > far) ? near : far;
        const float both = count > 0.0f ? (near_sum[j] + far_sum[j]) / count : window.middle;
        const bool by_side = window.method != CA && near_count[j] > 0.0f && far_count[j] > 0.0f;
        out[j] = by_side ? side : both;
    }
}

/* Fills above, (BLOCK,), with how many of the surroundings of each cell of a block are above its level. near, far: the
   first of those before the first cell, and behind it. */
static void count_above(const float *near, const float *far, int64_t train, const float *level, int32_t *above)
{
    Lanes levels[LANES_OF_BLOCK];
    Counts counts[LANES_OF_BLOCK];
#pragma GCC unroll 4
    for (int i = 0; i < LANES_OF_BLOCK; i++) {
        levels[i] = load(level + i * LANES);
        counts[i] = (Counts){0};
    }
    for (int64_t k = 0; k < train; k++)
#pragma GCC unroll 4
        for (int i = 0; i < LANES_OF_BLOCK; i++) { /* true is -1 */
            counts[i] -= load(near + k + i * LANES) > levels[i];
            counts[i] -= load(far + k + i * LANES) > levels[i];
        }
#pragma GCC unroll 4
    for (int i = 0; i < LANES_OF_BLOCK; i++)
        *(Counts *)(above + i * LANES) = counts[i];
}

/* Fills out, (BLOCK,), with the quantile `rank` of the surroundings of cells from `first` on, by halving an interval.
   At most total / most cells that are not negative can reach a level that `most` of them reach. */
static void quantiles(Row row, Window window, int64_t first, float *restrict out)
{
    float low[BLOCK], high[BLOCK], most[BLOCK], level[BLOCK];
    int32_t above[BLOCK];
    for (int64_t j = 0; j < BLOCK; j++) {
        const float cells = row.held[first + j] + row.held[first + window.behind + j];
        const float total = row.sums[first + j] + row.sums[first + window.behind + j];
        most[j] = (float)larger(cells * (1.0 - window.rank), 1.0);
        low[j] = cells > 0.0f ? 0.0f : window.middle;
        high[j] = cells > 0.0f ? total / most[j] : window.middle;
    }
    for (int halving = 0; halving < HALVINGS; halving++) {
        for (int64_t j = 0; j < BLOCK; j++)
            level[j] = 0.5f * (low[j] + high[j]);
        count_above(row.padded + first, row.padded + first + window.behind, window.train, level, above);
        for (int64_t j = 0; j < BLOCK; j++) {
            const bool reached = (float)above[j] >= most[j];
            low[j] = reached ? level[j] : low[j];
            high[j] = reached ? high[j] : level[j];
        }
    }
    for (int64_t j = 0; j < BLOCK; j++)
        out[j] = 0.5f * (low[j] + high[j]);
}

/* Fills out with image over the level of each cell's surroundings, at least LEAST of `middle`. Cells of 0 hold no data
   and do not count; where there are no others around, the level is `middle`. */
LONG_KERNEL(divide_by_surroundings, "f4[beams,samples] image, int method, int guard, int train, float rank, "
                                    "float middle, out f4[beams,samples] out")
{
    const int64_t samples = SIZE(0, 1), guard = larger_i(INT(2), 0), train = larger_i(INT(3), 1);
    const float middle = (float)FLOAT(5);
    const Window window = {INT(1), guard, train, FLOAT(4), train + 2 * guard + 1, middle, LEAST * middle};
    const int64_t length = samples + 2 * (guard + train) + BLOCK;
    const Row row = {ZEROS(float, length), SCRATCH(float, length), SCRATCH(float, length),
                     {SCRATCH(float, length), SCRATCH(float, length)}, length};
    float *restrict level = SCRATCH(float, samples + BLOCK);
    for (int64_t b = 0; b < SIZE(0, 0) && samples > 0; b++) {
        const float *restrict cells = ARRAY(const float, 0) + b * samples;
        float *restrict out = ARRAY(float, 6) + b * samples;
        surround(cells, samples, window, row);
        if (window.method == OS)
            for (int64_t first = 0; first < samples; first += BLOCK)
                quantiles(row, window, first, level + first);
        else
            averages(row, window, samples, level);
        for (int64_t j = 0; j < samples; j++)
            out[j] = cells[j] / larger_f(level[j], window.least);
    }
}
