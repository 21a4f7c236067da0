/* Connected regions by growing runs of cells from the cells above the high level. */

#include "ods/pipeline/detect/background/rise.h"
#include "ods/pipeline/image/regions.h"

/* Instead of a number: the image has cells that are no finite numbers. */
enum { NOT_A_NUMBER = -1 };
/* Cells that are looked at together, and runs of a region that are sorted one by one. */
#define BLOCK 64
/* Cells that are looked at together where they are not all low. */
#define FEW_CELLS 16
/* Beams that are fetched before their turn: regions grow into them, which the cache cannot foresee. */
#define AHEAD 4
#define CELLS_OF_LINE 16

/* An image whose regions are sought, by `GrowingRule`, and the runs found so far. */
typedef struct {
    const float *image; /* (beams, samples) */
    int64_t beams, samples;
    Rise rise;
    Levels low, high;
    int64_t corner; /* 1 when cells that touch by a corner are connected, 0 when they have to share a side */
    int64_t smallest, largest; /* cells of a region */
    bool *visited; /* (beams, samples) cells that are in a run */
    Run *runs;
    int64_t count, room;
} Growth;

/* Tells whether none of some cells is above the level, nor NaN. */
static inline bool all_up_to(const float *cells, const int64_t count, float level)
{
    int32_t others = 0;
    for (int64_t j = 0; j < count; j++)
        others |= !(cells[j] <= level);
    return others == 0;
}

/* Asks for a block of a beam that is soon to be looked at; there may be no such beam. */
static inline void fetch(const Growth *growth, int64_t beam, int64_t column)
{
    const int64_t cell = smaller_i(beam, growth->beams - 1) * growth->samples + column;
    for (int64_t j = 0; j < BLOCK; j += CELLS_OF_LINE)
        __builtin_prefetch(growth->image + cell + j);
    __builtin_prefetch(growth->visited + cell, 1);
}

static inline const float *along(const Growth *growth, Levels levels, int64_t beam)
{
    return levels_along(&growth->rise, levels, beam, growth->samples);
}

/* Returns the first cell of a beam from `from` on that is above the high level, or NaN; where there is none, one behind
   the last. */
static int64_t next_high(const Growth *growth, int64_t beam, int64_t from)
{
    const float *row = growth->image + beam * growth->samples, *high = along(growth, growth->high, beam);
    const float least = growth->high.least;
    while (from < growth->samples) {
        for (; from + BLOCK <= growth->samples && all_up_to(row + from, BLOCK, least); from += BLOCK)
            fetch(growth, beam + AHEAD, from);
        while (from + FEW_CELLS <= growth->samples && all_up_to(row + from, FEW_CELLS, least))
            from += FEW_CELLS;
        for (const int64_t stop = smaller_i(from + FEW_CELLS, growth->samples); from < stop; from++)
            if (!(row[from] <= high[from]))
                return from;
    }
    return from;
}

/* Adds the run of cells above the low level around one cell, as of region 0, and marks its cells. */
static void take_run(Growth *growth, int64_t beam, int64_t column)
{
    const float *row = growth->image + beam * growth->samples, *low = along(growth, growth->low, beam);
    int64_t first = column, stop = column + 1;
    while (first > 0 && row[first - 1] > low[first - 1])
        first--;
    while (stop < growth->samples && row[stop] > low[stop])
        stop++;
    memset(growth->visited + beam * growth->samples + first, true, (size_t)(stop - first));
    growth->runs[growth->count++] = (Run){(int32_t)beam, (int32_t)first, (int32_t)stop, 0};
}

/* Adds the runs in one beam that are connected with a run of the next one. */
static void take_neighbours(Growth *growth, int64_t beam, Run run)
{
    const float *row = growth->image + beam * growth->samples, *low = along(growth, growth->low, beam);
    const bool *visited = growth->visited + beam * growth->samples;
    const int64_t stop = smaller_i(run.stop + growth->corner, growth->samples);
    for (int64_t j = larger_i(run.first - growth->corner, 0); j < stop && growth->count < growth->room; j++)
        if (row[j] > low[j] && !visited[j])
            take_run(growth, beam, j);
}

/* Adds the runs of the region around one cell, and returns the number of its cells. */
static int64_t grow(Growth *growth, int64_t beam, int64_t column)
{
    int64_t cells = 0, i = growth->count;
    take_run(growth, beam, column);
    for (; i < growth->count; i++) {
        const Run run = growth->runs[i];
        cells += run.stop - run.first;
        if (run.beam > 0)
            take_neighbours(growth, run.beam - 1, run);
        if (run.beam + 1 < growth->beams)
            take_neighbours(growth, run.beam + 1, run);
    }
    return cells;
}

/* Sorts the runs of one region by beam and column. */
static void sort(Run *runs, int64_t count)
{
    if (count > BLOCK) {
        Run *sorted = SCRATCH(Run, count);
        sorted_runs(runs, count, sorted);
        memcpy(runs, sorted, (size_t)count * sizeof *runs);
        return;
    }
    for (int64_t i = 1; i < count; i++) {
        const Run run = runs[i];
        int64_t k = i;
        for (; k > 0 && order_of_run(runs[k - 1]) > order_of_run(run); k--)
            runs[k] = runs[k - 1];
        runs[k] = run;
    }
}

/* Grows the region around one cell, and numbers it; returns its number, or the last one if it is of no good size. */
static int64_t take_region(Growth *growth, int64_t beam, int64_t column, int64_t last)
{
    const int64_t before = growth->count, cells = grow(growth, beam, column);
    if (cells < growth->smallest || cells > growth->largest)
        return last;
    Run *runs = growth->runs + before;
    for (int64_t i = 0; i < growth->count - before; i++)
        runs[i].region = (int32_t)last + 1;
    sort(runs, growth->count - before);
    return last + 1;
}

/* Grows the regions of the cells of a beam above the high level, and numbers them from `number` + 1 on; returns the last number,
   NOT_A_NUMBER where a cell is no finite number. */
static int64_t grow_beam(Growth *growth, int64_t beam, int64_t number)
{
    const float *row = growth->image + beam * growth->samples;
    const bool *visited = growth->visited + beam * growth->samples;
    int64_t j = next_high(growth, beam, 0);
    while (j < growth->samples) {
        if (!isfinite(row[j]))
            return NOT_A_NUMBER;
        if (!visited[j] && growth->count < growth->room)
            number = take_region(growth, beam, j, number);
        for (j++; j < growth->samples && visited[j] && isfinite(row[j]);) /* the rest of its run */
            j++;
        j = next_high(growth, beam, j);
    }
    return number;
}

/* Forgets what was visited, and runs of no region; returns how many are left. */
static int64_t settle(Growth *growth)
{
    int64_t kept = 0;
    for (int64_t i = 0; i < growth->count; i++) {
        const Run run = growth->runs[i];
        memset(growth->visited + run.beam * growth->samples + run.first, false, (size_t)(run.stop - run.first));
        growth->runs[kept] = run;
        kept += run.region > 0;
    }
    return kept;
}

/* Fills runs with those of all regions, sorted, and returns how many; NOT_A_NUMBER where a cell is no finite number.
   A region is grown, run by run, from a cell above the high level; so the time goes with what is found, not with the
   many cells of speckle above the low one. */
KERNEL_INT(find_regions, "f4[beams,samples] image, float low, float high, int corner, int smallest, int largest, " RISE
                         ", out r16[room] runs, out b1[beams,samples] visited")
{
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1);
    const Rise rise = rise_at(arguments + 6);
    Growth growth = {.image = ARRAY(const float, 0), .beams = beams, .samples = samples, .rise = rise,
                     .low = risen(&rise, smaller(FLOAT(1), FLOAT(2)), rise.low_power, samples),
                     .high = risen(&rise, FLOAT(2), rise.high_power, samples),
                     .corner = INT(3) != 0, .smallest = INT(4), .largest = INT(5)};
    arguments += 6 + arguments_of(RISE);
    growth.runs = ARRAY(Run, 0), growth.room = SIZE(0, 0), growth.visited = ARRAY(bool, 1);
    int64_t number = 0;
    for (int64_t b = 0; b < growth.beams && number >= 0; b++)
        number = grow_beam(&growth, b, number);
    const int64_t kept = settle(&growth);
    return number < 0 ? NOT_A_NUMBER : kept;
}
