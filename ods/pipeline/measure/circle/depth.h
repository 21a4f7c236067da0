/* Along the beams: where an echo begins and ends, and whether it is of a whole body or of its front.

   An edge lies where the echo has half the level of its outermost crest: a symmetric filter leaves that point of a step
   in place, whatever the threshold. An echo as short as the filter's response is that of a point, which lies at the
   crest. */

#ifndef ODS_DEPTH_H
#define ODS_DEPTH_H

#include "ods/pipeline/measure/region.h"

/* Where in its depth the middle of an echo's intensity lies: a sphere's front pales behind its crest [SSIE eq. 3], a
   body that shines all over stays level. */
#define FRONT_MIDDLE 0.41
#define BODY_MIDDLE 0.47
/* Share of the level where the crest of a step begins. */
#define TOP 0.97f
/* An echo of which the mean level is less than this, in multiples of the background, may be a fragment of its body, */
#define WEAK 3.5
/* and below this there is a standard deviation of how much nearer its body begins. */
#define FADES 2.35
#define HIDDEN_FRONT_M 0.3
/* A body goes on beyond the echo found as long as the level is this share of the echo's over the background. */
#define GOES_ON 0.25
/* Sums of levels over that, in multiples of the background, with which it does, and at which the search ends. */
#define SURE 2.0
#define LOST 6.0

/* Where runs begin and end, with sub-cell accuracy: slant ranges, (runs,). */
typedef struct {
    double *near_m, *far_m;
} Ends;

/* An echo along the line of sight: fields of depth.Depth. */
typedef struct {
    double near_m, far_m, rise_m, middle, whole, hidden_m;
} Depth;

/* Returns how many cells before the first crest are, of `count` cells seen from one end of a run; step: 1 or -1. */
static inline int64_t first_crest(const float *end, int64_t count, int64_t step)
{
    int64_t crest = 0;
    while (crest < count - 1 && end[step * (crest + 1)] > end[step * crest])
        crest++;
    return crest;
}

/* Returns how many cells lie outside the point of half the level of the first crest, seen from one end of a run. */
static inline int64_t cells_outside(const float *end, int64_t count, int64_t step)
{
    const int64_t crest = first_crest(end, count, step);
    const float half = 0.5f * end[step * crest];
    int64_t outside = 0;
    while (outside < crest && end[step * outside] < half)
        outside++;
    return smaller_i(outside, (count - 1) / 2);
}

/* Fills in where each run begins and ends. */
static inline void find_ends(const Region *region, const FanTable *fan, Ends ends)
{
    for (int64_t i = 0; i < region->count; i++) {
        const Run run = region->runs[i];
        const float *row = row_of(region, run.beam);
        const int64_t count = run.stop - run.first;
        const int64_t first = run.first + cells_outside(row + run.first, count, 1);
        const int64_t stop = run.stop - cells_outside(row + run.stop - 1, count, -1);
        ends.near_m[i] = fan->range0_m + ((double)first - 0.5) * fan->dr_m;
        ends.far_m[i] = fan->range0_m + ((double)stop - 0.5) * fan->dr_m;
    }
}

/* Returns half the width, cells, of a crest of Gaussian shape as sharp as this one, at half its level. */
static inline double half_width(const float *row, int64_t columns, int64_t crest)
{
    if (crest == 0 || crest + 1 == columns)
        return 1.0;
    const double sharpness = 2.0 * row[crest] - row[crest - 1] - row[crest + 1];
    return sqrt(2.0 * log(2.0) * row[crest] / larger(1e-3 * row[crest], sharpness));
}

/* Returns how far the first crest of a run lies behind `near_m`, where it has half of its level, m.

   Not farther than it is wide: what rises longer than the filter's response does is speckle on a body. */
static inline double rise_of(const Region *region, Run run, const FanTable *fan, double near_m)
{
    const float *row = row_of(region, run.beam);
    int64_t crest = run.first + first_crest(row + run.first, run.stop - run.first, 1);
    double rise = fan->range0_m + (double)crest * fan->dr_m - near_m;
    rise = smaller(half_width(row, region->columns, crest) * fan->dr_m, rise);
    const float top = TOP * row[crest];
    while (crest > run.first && row[crest - 1] >= top)
        crest--;
    const double before_top = 1.0 - sqrt(log(TOP) / log(0.5)); /* of the rise from half of it, for a Gaussian */
    rise = smaller((fan->range0_m + (double)crest * fan->dr_m - near_m) / before_top, rise);
    return larger(0.5 * fan->dr_m, rise);
}

/* Returns the mean range of the echo's cells, weighted by their intensity over the background's. */
static inline double middle_m(const Region *region, double background, const FanTable *fan)
{
    double total = 0.0, moment = 0.0;
    for (int64_t i = 0; i < region->count; i++) {
        const Run run = region->runs[i];
        const float *row = row_of(region, run.beam);
        for (int64_t j = run.first; j < run.stop; j++) {
            const double weight = larger(0.0, (double)(row[j] * row[j]) - background * background);
            total += weight;
            moment += weight * (double)j;
        }
    }
    return fan->range0_m + moment / larger(1e-30, total) * fan->dr_m;
}

/* Returns how many columns further a body reaches whose level is at least `least`, by the sum of what is over it:
   of `count` columns beyond the echo, from `column` on outwards; step: 1 or -1. */
static inline double goes_on(const Region *region, int64_t column, int64_t step, int64_t count, double background,
                             double least)
{
    double total = 0.0, best = SURE * background;
    int64_t columns = 0;
    for (int64_t j = 0; j < count && !(total < best - LOST * background); j++) {
        for (int64_t b = region->low; b <= region->high; b++)
            total += row_of(region, b)[column + step * j] - least;
        if (total > best)
            best = total, columns = j + 1;
    }
    return (double)columns;
}

/* Moves the ends of an echo so weak that it may be a fragment to where its body may end.

   A fragment deep inside a body looks like a front; it does not show how deep the body is. */
static inline void reach_further(const Region *region, double background, double mean, const FanTable *fan,
                                 Depth *depth)
{
    const double least = background * (1.0 + GOES_ON * (mean - 1.0));
    depth->near_m -= goes_on(region, region->first - 1, -1, region->first, background, least) * fan->dr_m;
    if (depth->whole > 0.0)
        depth->far_m += goes_on(region, region->stop, 1, region->columns - region->stop, background, least) * fan->dr_m;
}

/* Returns the depth of an echo, whose ends are `ends`; mean: its level, in multiples of the background. */
static inline Depth depth_of(const Region *region, Ends ends, double background, double mean, const FanTable *fan)
{
    int64_t nearest = 0;
    double far_m = ends.far_m[0];
    for (int64_t i = 0; i < region->count; i++) {
        nearest = ends.near_m[i] < ends.near_m[nearest] ? i : nearest;
        far_m = larger(ends.far_m[i], far_m);
    }
    Depth depth = {.near_m = ends.near_m[nearest]};
    depth.rise_m = rise_of(region, region->runs[nearest], fan, depth.near_m);
    const double part = 2.0 * depth.rise_m / larger(fan->dr_m, far_m - depth.near_m);
    depth.near_m += depth.rise_m * smaller(part * part, 1.0);
    depth.far_m = larger(depth.near_m + 0.5 * fan->dr_m, far_m);
    depth.middle = (middle_m(region, background, fan) - depth.near_m) / (depth.far_m - depth.near_m);
    depth.whole = held((depth.middle - FRONT_MIDDLE) / (BODY_MIDDLE - FRONT_MIDDLE), 0.0, 1.0);
    depth.hidden_m = HIDDEN_FRONT_M * depth.whole * held((FADES - mean) / 0.4, 0.0, 1.0);
    if (mean < WEAK)
        reach_further(region, background, mean, fan, &depth);
    return depth;
}

#endif
