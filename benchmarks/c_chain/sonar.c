/* A whole chain in plain C: what a frame costs at least on this processor, by which ours is judged.

   Equalize by the mean of each range, filter along the beams, regions above a low level that reach a high one, a circle
   around each. It does only that: no geometry but even beams, no gaps, no uncertainties, no checks. */

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#ifdef __AVX512BW__
#include <immintrin.h>
#endif

#include "rows.h" /* made by rows.py: fir_row, median_row */

#define WINDOW 9 /* samples of each filter */
#define HALF (WINDOW / 2)
#define BLOCK 512 /* columns that are equalized together: their sums stay in the nearest cache */
#define MOST_COLUMNS 8192
#define MOST_BEAMS 1024
#define MOST_RUNS 200000
#define PADDED(name) float name[MOST_COLUMNS + 128] __attribute__((aligned(64)))
#define EXPORT __attribute__((visibility("default")))

enum { FIR, WIENER, MEDIAN };

/* What is asked for; plain_c.py has the same structure. */
typedef struct {
    const void *frame; /* (beams, columns) of 8 or 16 bits */
    int64_t bits, beams, columns;
    int64_t filter;
    const float *taps;                      /* (WINDOW,) of the FIR filter */
    float *equalized, *filtered, *variance; /* work space, (beams, columns) each */
    double low, high;                       /* levels, in multiples of the mean of each range */
    double first_rad, spacing_rad, range0_m, dr_m;
} Job;

typedef struct {
    float ahead_m, starboard_m, radius_m, peak;
    int32_t cells, beam, column; /* place of the peak */
} Detection;

/* Neighbouring cells of a beam over the low level. */
typedef struct {
    int32_t beam, first, last, next; /* next: run of the same region, -1: none */
} Run;

/* ---------------------------------------------------------------- equalization */

/* Defines the division of BLOCK columns, or fewer at the end, by their means over the beams. */
#define EQUALIZE(NAME, TYPE)                                                                                           \
    static void NAME(const TYPE *restrict frame, float *restrict out, long beams, long columns)                        \
    {                                                                                                                  \
        uint32_t sum[BLOCK] __attribute__((aligned(64)));                                                              \
        float scale[BLOCK] __attribute__((aligned(64)));                                                               \
        for (long begin = 0; begin < columns; begin += BLOCK) {                                                        \
            const long count = columns - begin < BLOCK ? columns - begin : BLOCK;                                      \
            memset(sum, 0, sizeof sum);                                                                                \
            for (long b = 0; b < beams; b++) {                                                                         \
                const TYPE *restrict row = frame + b * columns + begin;                                                \
                for (long j = 0; j < count; j++)                                                                       \
                    sum[j] += (uint32_t)row[j];                                                                        \
            }                                                                                                          \
            for (long j = 0; j < count; j++)                                                                           \
                scale[j] = sum[j] > 0 ? (float)beams / (float)sum[j] : 0.0f;                                           \
            for (long b = 0; b < beams; b++) {                                                                         \
                const TYPE *restrict row = frame + b * columns + begin;                                                \
                float *restrict equal = out + b * columns + begin;                                                     \
                for (long j = 0; j < count; j++)                                                                       \
                    equal[j] = (float)row[j] * scale[j];                                                               \
            }                                                                                                          \
        }                                                                                                              \
    }
EQUALIZE(equalize_8, uint8_t)
EQUALIZE(equalize_16, uint16_t)

/* ---------------------------------------------------------------- filters; beyond its ends a beam goes on level */

/* Fills padded (HALF + count + HALF, and 64 more). */
static inline void pad(const float *restrict row, float *restrict padded, long count)
{
    for (long j = 0; j < HALF; j++)
        padded[j] = row[0];
    memcpy(padded + HALF, row, count * sizeof *row);
    for (long j = 0; j < HALF + 64; j++)
        padded[HALF + count + j] = row[count - 1];
}

static void fir(const Job *job)
{
    PADDED(padded);
    for (long b = 0; b < job->beams; b++) {
        pad(job->equalized + b * job->columns, padded, job->columns);
        fir_row(padded, job->filtered + b * job->columns, job->columns, job->taps);
    }
}

static void median(const Job *job)
{
    PADDED(padded);
    for (long b = 0; b < job->beams; b++) {
        pad(job->equalized + b * job->columns, padded, job->columns);
        median_row(padded, job->filtered + b * job->columns, job->columns);
    }
}

/* Fills sums (count,) with those of WINDOW neighbours: of 2, then of 4, then of 8 of them, and one. */
static inline void window_sums(const float *restrict padded, float *restrict sums, long count)
{
    PADDED(pairs);
    PADDED(fours);
    for (long j = 0; j < count + 6; j++)
        pairs[j] = padded[j] + padded[j + 1];
    for (long j = 0; j < count + 4; j++)
        fours[j] = pairs[j] + pairs[j + 2];
    for (long j = 0; j < count; j++)
        sums[j] = fours[j] + fours[j + 4] + padded[j + 8];
}

/* As scipy.signal.wiener: the noise is the mean of the local variance over the frame. */
static void wiener(const Job *job)
{
    PADDED(padded);
    PADDED(squares);
    const long columns = job->columns, cells = job->beams * columns;
    const float scale = 1.0f / WINDOW;
    double total = 0.0;
    for (long b = 0; b < job->beams; b++) {
        float *restrict mean = job->filtered + b * columns, *restrict variance = job->variance + b * columns;
        float sum = 0.0f;
        pad(job->equalized + b * columns, padded, columns);
        for (long j = 0; j < columns + 2 * HALF; j++)
            squares[j] = padded[j] * padded[j];
        window_sums(padded, mean, columns);
        window_sums(squares, variance, columns);
        for (long j = 0; j < columns; j++) {
            mean[j] *= scale;
            variance[j] = variance[j] * scale - mean[j] * mean[j];
            sum += variance[j];
        }
        total += sum;
    }
    const float noise = (float)(total / (double)cells);
    const float *restrict equalized = job->equalized, *restrict variance = job->variance;
    float *restrict out = job->filtered;
    for (long j = 0; j < cells; j++) {
        const float larger = variance[j] > noise ? variance[j] : noise;
        out[j] += (1.0f - noise / larger) * (equalized[j] - out[j]);
    }
}

/* ---------------------------------------------------------------- detection */

static Run runs[MOST_RUNS];
static int32_t parent[MOST_RUNS], newest[MOST_RUNS];
static uint8_t is_high[MOST_RUNS];

static inline int root_of(int run)
{
    while (parent[run] != run)
        run = parent[run] = parent[parent[run]];
    return run;
}

/* What a row of cells is cut into runs by: whether a run is open, and how many there are. */
typedef struct {
    int open, count;
} Cut;

static inline void cut_at(Cut *cut, int32_t beam, int32_t column)
{
    if (cut->open)
        runs[cut->count++].last = column - 1;
    else
        runs[cut->count] = (Run){beam, column, 0, -1};
    cut->open = !cut->open;
}

#ifdef __AVX512BW__
static inline uint64_t above(const float *row, __m512 low)
{
    uint64_t found = 0;
    for (int k = 0; k < 4; k++)
        found |= (uint64_t)_mm512_cmp_ps_mask(_mm512_loadu_ps(row + 16 * k), low, _CMP_GT_OQ) << 16 * k;
    return found;
}

/* Appends the runs of a beam to `count` others; returns how many there are then. */
static int runs_of_row(const float *restrict row, int32_t beam, int32_t columns, float low, int count)
{
    Cut cut = {0, count};
    for (int32_t j = 0; j < columns; j += 64) {
        uint64_t found = 0;
        if (j + 64 <= columns)
            found = above(row + j, _mm512_set1_ps(low));
        else
            for (int k = 0; k < columns - j; k++)
                found |= (uint64_t)(row[j + k] > low) << k;
        for (uint64_t edges = found ^ (found << 1 | (uint64_t)cut.open); edges != 0; edges &= edges - 1)
            cut_at(&cut, beam, j + __builtin_ctzll(edges));
    }
    if (cut.open)
        cut_at(&cut, beam, columns);
    return cut.count;
}
#else
/* Appends the runs of a beam to `count` others; returns how many there are then. */
static int runs_of_row(const float *restrict row, int32_t beam, int32_t columns, float low, int count)
{
    uint8_t over[MOST_COLUMNS + 8];
    Cut cut = {0, count};
    for (int32_t j = 0; j < columns; j++)
        over[j] = row[j] > low;
    memset(over + columns, 0, 8);
    for (int32_t j = 0; j < columns; j += 8) {
        uint64_t eight;
        memcpy(&eight, over + j, sizeof eight);
        if (eight == (cut.open ? 0x0101010101010101u : 0u))
            continue;
        for (int32_t k = j; k < j + 8 && k < columns; k++)
            if (over[k] != cut.open)
                cut_at(&cut, beam, k);
    }
    if (cut.open)
        cut_at(&cut, beam, columns);
    return cut.count;
}
#endif

/* Joins the runs from `begin` on with those of the beam before, from `before` on, that they touch, corners too. */
static void join(int before, int begin, int end)
{
    int first = before;
    for (int i = begin; i < end; i++) {
        while (first < begin && runs[first].last < runs[i].first - 1)
            first++;
        for (int k = first; k < begin && runs[k].first <= runs[i].last + 1; k++) {
            const int a = root_of(i), b = root_of(k);
            parent[a > b ? a : b] = a > b ? b : a;
        }
    }
}

/* Finds all runs and the regions they belong to; returns how many runs. */
static int find_runs(const Job *job)
{
    int before = 0, count = 0;
    for (long b = 0; b < job->beams && count < MOST_RUNS - job->columns / 2 - 2; b++) {
        const float *row = job->filtered + b * job->columns;
        const int begin = count;
        count = runs_of_row(row, (int32_t)b, (int32_t)job->columns, (float)job->low, begin);
        for (int i = begin; i < count; i++) {
            parent[i] = i;
            int high = 0;
            for (int j = runs[i].first; j <= runs[i].last; j++)
                high |= row[j] > (float)job->high;
            is_high[i] = (uint8_t)high;
        }
        join(before, begin, count);
        before = begin;
    }
    return count;
}

/* Links the runs of each region that reaches the high level, in rising order from newest[its root] on. */
static void link_runs(int count)
{
    enum { NONE = -1, WANTED = -2 };
    for (int i = 0; i < count; i++)
        newest[i] = NONE;
    for (int i = 0; i < count; i++)
        if (is_high[i])
            newest[root_of(i)] = WANTED;
    for (int i = count - 1; i >= 0; i--) {
        const int root = root_of(i);
        if (newest[root] != NONE) {
            runs[i].next = newest[root] == WANTED ? -1 : newest[root];
            newest[root] = i;
        }
    }
}

/* Returns the circle around the middle of a region through the farthest end of its runs, and its highest level. */
static Detection measured(const Job *job, int first, const float *cosine, const float *sine)
{
    Detection found = {.peak = -1e30f};
    double ahead = 0.0, starboard = 0.0, square = 0.0;
    for (int i = first; i >= 0; i = runs[i].next) {
        const Run run = runs[i];
        const float *row = job->filtered + run.beam * job->columns;
        const int cells = run.last - run.first + 1;
        for (int j = run.first; j <= run.last; j++)
            if (row[j] > found.peak)
                found.peak = row[j], found.beam = run.beam, found.column = j;
        const double sum = cells * (job->range0_m + 0.5 * job->dr_m * (run.first + run.last));
        found.cells += cells;
        ahead += sum * cosine[run.beam], starboard += sum * sine[run.beam];
    }
    ahead /= found.cells, starboard /= found.cells;
    for (int i = first; i >= 0; i = runs[i].next)
        for (int end = 0; end < 2; end++) {
            const double range = job->range0_m + job->dr_m * (end ? runs[i].last : runs[i].first);
            const double dx = range * cosine[runs[i].beam] - ahead, dy = range * sine[runs[i].beam] - starboard;
            square = dx * dx + dy * dy > square ? dx * dx + dy * dy : square;
        }
    found.ahead_m = (float)ahead, found.starboard_m = (float)starboard, found.radius_m = (float)sqrt(square);
    return found;
}

/* Fills found with the detections of a frame; returns how many, at most `most`. */
EXPORT int detections(const Job *job, Detection *restrict found, int most)
{
    float cosine[MOST_BEAMS], sine[MOST_BEAMS];
    if (job->beams > MOST_BEAMS || job->columns > MOST_COLUMNS)
        abort();
    if (job->bits == 8)
        equalize_8(job->frame, job->equalized, job->beams, job->columns);
    else
        equalize_16(job->frame, job->equalized, job->beams, job->columns);
    (job->filter == FIR ? fir : job->filter == WIENER ? wiener : median)(job);
    const int count = find_runs(job);
    link_runs(count);
    for (long b = 0; b < job->beams; b++) {
        cosine[b] = cosf((float)(job->first_rad + (double)b * job->spacing_rad));
        sine[b] = sinf((float)(job->first_rad + (double)b * job->spacing_rad));
    }
    int regions = 0;
    for (int i = 0; i < count && regions < most; i++)
        if (parent[i] == i && newest[i] >= 0)
            found[regions++] = measured(job, newest[i], cosine, sine);
    return regions;
}
