/* What the image kernels know of the sonar (see grid.py), and its beam patterns looked up. */

#ifndef ODS_GRID_H
#define ODS_GRID_H

#include "kernel.h"

/* Points over which the vertical pattern is averaged, for one unit of sin(elevation). */
#define STEPS_PER_SINE 128.0

typedef struct {
    double edge_m, dr_m;         /* near edge of the first range bin, and the bins' length */
    int64_t samples;
    const double *bearing_rad;   /* (beams,) of one plane */
    double beam_width_rad;
    const double *vertical;      /* (planes, vertical_nodes) S^2, even over sin(elevation) from -1 to 1 */
    const double *vertical_sum;  /* (planes, sum_nodes) its running integral from sin(elevation) = -1 on */
    const double *horizontal;    /* (horizontal_nodes,) running integral of the horizontal pattern over beam widths */
    int64_t nodes_per_width;     /* nodes of `horizontal` in one beam width */
    double lit_beyond_rad;       /* fine columns reach so far beyond the outer beams */
    int64_t beams, planes, vertical_nodes, sum_nodes, horizontal_nodes;
} Grid;

/* A `Grid` in a signature: ten arguments. */
#define GRID                                                                                                            \
    "float edge_m, float dr_m, int samples, f8[beams] bearing_rad, float beam_width_rad, f8[planes,:] vertical, "       \
    "f8[planes,:] vertical_sum, f8[:] horizontal, int nodes_per_width, float lit_beyond_rad"

/* Returns the grid of the ten arguments from number k on. */
static inline Grid grid_from(const Argument *arguments, int k)
{
    return (Grid){
        .edge_m = FLOAT(k),
        .dr_m = FLOAT(k + 1),
        .samples = INT(k + 2),
        .bearing_rad = ARRAY(const double, k + 3),
        .beam_width_rad = FLOAT(k + 4),
        .vertical = ARRAY(const double, k + 5),
        .vertical_sum = ARRAY(const double, k + 6),
        .horizontal = ARRAY(const double, k + 7),
        .nodes_per_width = INT(k + 8),
        .lit_beyond_rad = FLOAT(k + 9),
        .beams = SIZE(k + 3, 0),
        .planes = SIZE(k + 5, 0),
        .vertical_nodes = SIZE(k + 5, 1),
        .sum_nodes = SIZE(k + 6, 1),
        .horizontal_nodes = SIZE(k + 7, 0),
    };
}

/* Returns a place as a whole number, kept between 0 and `most`; 0 for NaN. */
static inline int32_t node_at(double place, double most)
{
    return (int32_t)smaller(larger(place, 0.0), most);
}

/* Returns the mean of S^2 of one plane between two values of sin(elevation). */
static inline double mean_two_way(const Grid *grid, int64_t plane, double low, double high)
{
    const double *table = grid->vertical + plane * grid->vertical_nodes;
    const double most = (double)(grid->vertical_nodes - 2), scale = 0.5 * (double)(grid->vertical_nodes - 1);
    const int32_t steps = 1 + node_at(fabs(high - low) * STEPS_PER_SINE, 1e6);
    double total = 0.0;
    for (int32_t k = 0; k < steps; k++) {
        const double sine = low + (high - low) * (k + 0.5) / steps;
        const double place = (sine + 1.0) * scale;
        const int32_t node = node_at(place, most);
        total += table[node] + (place - node) * (table[node + 1] - table[node]);
    }
    return total / steps;
}

/* Returns the running integral of the horizontal pattern up to an offset in beam widths. */
static inline double running_pattern(const Grid *grid, double offset)
{
    const double *table = grid->horizontal;
    const double place = offset * (double)grid->nodes_per_width + 0.5 * (double)(grid->horizontal_nodes - 1);
    const int32_t node = node_at(place, (double)(grid->horizontal_nodes - 2));
    const double share = smaller(larger(place - node, 0.0), 1.0);
    return table[node] + share * (table[node + 1] - table[node]);
}

/* Returns the horizontal pattern's integral from `first` to `last`, offsets and result in beam widths. */
static inline double beam_share(const Grid *grid, double first, double last)
{
    return running_pattern(grid, last) - running_pattern(grid, first);
}

#endif
