/* The echo of a sea-bed's columns, as beams hear it. */

#include "ods/sim_sonar/echo/mixing.h"

/* Places at which the change from one column to the next is sampled. */
#define BLEND 4

/* Adds the mean of all `columns` (planes, count, samples), times each beam's `share` (beams,), rad, to `bins`. */
static void add_mean(double *image, const double *columns, int64_t count, Bins bins, const double *share, const Grid *grid)
{
    const int64_t samples = grid->samples, width = bins.last - bins.first;
    double *mean = SCRATCH(double, width);
    for (int64_t plane = 0; plane < grid->planes; plane++) {
        memset(mean, 0, (size_t)width * sizeof *mean);
        for (int64_t a = 0; a < count; a++)
            add_share(mean, columns + (plane * count + a) * samples + bins.first, 1.0, width);
        for (int64_t beam = 0; beam < grid->beams; beam++)
            add_share(image + (plane * grid->beams + beam) * samples + bins.first, mean, share[beam] / (double)count, width);
    }
}

/* Adds evenly wide `columns`, m2 per radian of bearing, between the borders `bearing` to bins [first, last) of `image`.
   A beam hears what lies beyond `reach` beam widths of its axis as the mean of all. */
LONG_KERNEL(mix_evenly, "out f8[:,bins] image, f8[planes,columns,bins] columns, int first, int last, f8[:] bearing, " GRID
                        ", float reach")
{
    const double *columns = ARRAY(const double, 1), *bearing = ARRAY(const double, 4);
    const int64_t count = SIZE(1, 1);
    const Bins bins = {INT(2), INT(3)};
    const Grid grid = grid_from(arguments, 5);
    double *shares = SCRATCH(double, grid.beams * count), *rest = SCRATCH(double, grid.beams);
    blended_shares(bearing, count, &grid, FLOAT(15), BLEND, shares);
    mix_columns(ARRAY(double, 0), columns, count, bins, shares, &grid);
    const double whole = pattern_width(&grid);
    for (int64_t beam = 0; beam < grid.beams; beam++) {
        rest[beam] = whole;
        for (int64_t a = 0; a < count; a++)
            rest[beam] -= shares[beam * count + a];
    }
    add_mean(ARRAY(double, 0), columns, count, bins, rest, &grid);
}
