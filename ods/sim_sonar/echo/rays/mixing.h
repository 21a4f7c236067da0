/* How thin columns of the fan become beams: each beam receives them through its horizontal pattern. */

#ifndef ODS_MIXING_H
#define ODS_MIXING_H

#include "ods/sim_sonar/echo/rays/fan.h"
#include "ods/sim_sonar/sonar/grid.h"

/* Overlap, in beam widths, that is none: columns and beams on one raster must not hang on rounding. */
#define NO_OVERLAP 1e-9

/* Returns the integral of the horizontal pattern over half a turn, rad. */
static inline double pattern_width(const Grid *grid)
{
    const double widest = RIGHT / grid->beam_width_rad;
    return beam_share(grid, -widest, widest) * grid->beam_width_rad;
}

/* Returns the integral of one beam's horizontal pattern up to `offset`, in beam widths, as the mean over `parts` places
   that are spread over `width`. */
static inline double blended_pattern(const Grid *grid, double offset, double width, int parts)
{
    double total = 0.0;
    for (int part = 0; part < parts; part++)
        total += running_pattern(grid, offset + ((part + 0.5) / parts - 0.5) * width);
    return total / parts;
}

/* Sets `out` (beams, columns) to how much each beam receives of each column between the rising borders `bearing`, rad. A
   beam receives nothing of columns beyond `reach` beam widths of its axis.

   `parts`: places at which the change from one column to the next is sampled. One where there is a step; more of evenly
   wide columns between which what is received changes linearly. */
static inline void blended_shares(const double *restrict bearing, int64_t columns, const Grid *grid, double reach,
                                  int parts, double *restrict out)
{
    const double beam_width = grid->beam_width_rad, width = (bearing[1] - bearing[0]) / beam_width;
    for (int64_t beam = 0; beam < grid->beams; beam++) {
        const double axis = grid->bearing_rad[beam];
        double *restrict row = out + beam * columns;
        int64_t low = 0, high = columns;
        while (low < columns && !((bearing[low + 1] - axis) / beam_width > NO_OVERLAP - reach))
            row[low++] = 0.0;
        while (high > low && !((bearing[high - 1] - axis) / beam_width < reach - NO_OVERLAP))
            row[--high] = 0.0;
        if (low == high)
            continue;
        for (int64_t a = low; a < high; a++)
            row[a] = blended_pattern(grid, (bearing[a] - axis) / beam_width, width, parts) * beam_width;
        const double end = blended_pattern(grid, (bearing[high] - axis) / beam_width, width, parts) * beam_width;
        for (int64_t a = low; a + 1 < high; a++)
            row[a] = row[a + 1] - row[a];
        row[high - 1] = end - row[high - 1];
    }
}

static inline void shares_of(const double *bearing, int64_t columns, const Grid *grid, double reach, double *out)
{
    blended_shares(bearing, columns, grid, reach, 1, out);
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
