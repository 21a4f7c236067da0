/* How thin columns of the fan become beams: each beam hears them through its horizontal pattern. */

#ifndef ODS_MIXING_H
#define ODS_MIXING_H

#include "ods/sim_sonar/echo/fan.h"
#include "ods/sim_sonar/sonar/grid.h"

/* Returns the integral of the horizontal pattern over half a turn, rad. */
static inline double pattern_width_of(const Grid *grid)
{
    const double widest = RIGHT / grid->beam_width_rad;
    return beam_share(grid, -widest, widest) * grid->beam_width_rad;
}

/* Sets `out` (beams, columns) to how much each beam hears of each column between the borders `bearing`, rad. A beam
   hears nothing of columns beyond `reach` beam widths of its axis. */
static inline void shares_of(const double *restrict bearing, int64_t columns, const Grid *grid, double reach,
                             double *restrict out)
{
    const double width = grid->beam_width_rad;
    for (int64_t beam = 0; beam < grid->beams; beam++)
        for (int64_t a = 0; a < columns; a++) {
            const double begin = (bearing[a] - grid->bearing_rad[beam]) / width;
            const double finish = (bearing[a + 1] - grid->bearing_rad[beam]) / width;
            const bool heard = finish >= -reach && begin <= reach;
            out[beam * columns + a] = heard ? beam_share(grid, begin, finish) * width : 0.0;
        }
}

static inline void add_share(double *restrict target, const double *restrict source, double share, int64_t bins)
{
    for (int64_t j = 0; j < bins; j++)
        target[j] += share * source[j];
}

/* Adds `columns` (planes, columns, samples), per radian of bearing, to `bins` of `image` (planes * beams, samples).
   `shares` (beams, columns), rad. */
static inline void mix_columns(double *image, const double *columns, int64_t count, Bins bins, const double *shares,
                               const Grid *grid)
{
    const int64_t samples = grid->samples;
    for (int64_t beam = 0; beam < grid->beams; beam++)
        for (int64_t a = 0; a < count; a++) {
            const double share = shares[beam * count + a];
            for (int64_t plane = 0; plane < grid->planes && share != 0.0; plane++)
                add_share(image + (plane * grid->beams + beam) * samples + bins.first,
                          columns + (plane * count + a) * samples + bins.first, share, bins.last - bins.first);
        }
}

#endif
