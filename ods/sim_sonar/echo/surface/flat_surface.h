/* The echo of a plane, eq. 5 integrated over each range bin in closed form.

   At a bearing, the points of a plane at slant range R lie at the elevation b with (n . u(b)) R = h: n is the direction
   straight to the plane in the sonar's frame, h its distance. A bin's solid angle per radian of bearing is the
   difference of sin(b) between its edges, so that not even the singular start of the echo, straight ahead of it, needs
   a fine grid. */

#ifndef ODS_FLAT_SURFACE_H
#define ODS_FLAT_SURFACE_H

#include "ods/sim_sonar/echo/rays/fan.h"
#include "ods/sim_sonar/echo/surface/reflection.h"
#include "ods/sim_sonar/sonar/grid.h"

/* Tilt, in radians, that is none. */
#define LEVEL 1e-9
/* Least distance of a bin, m: its inverse is finite. */
#define LEAST_DISTANCE 1e-9

/* A plane as the sonar sees it (see flat_surface.py), and two rows of `samples` + 1 numbers to work in. */
typedef struct {
    const double *down; /* (3,) */
    double height_m;
    const double *weight;   /* (samples,) */
    const double *nearness; /* (samples + 1,) */
    double *place, *received;
} FlatSurface;

/* A `FlatSurface` in a signature: four arguments. */
#define FLAT_SURFACE "f8[3] down, float height_m, f8[:] weight, f8[:] nearness"

/* Returns the plane of the four arguments from number k on. */
static inline FlatSurface flat_surface_from(const Argument *arguments, int k)
{
    return (FlatSurface){
        .down = ARRAY(const double, k),
        .height_m = FLOAT(k + 1),
        .weight = ARRAY(const double, k + 2),
        .nearness = ARRAY(const double, k + 3),
        .place = SCRATCH(double, SIZE(k + 3, 0)),
        .received = SCRATCH(double, SIZE(k + 3, 0)),
    };
}

/* Sets gamma R^2 at the samples of a plane, (samples,), and 1 / R at their borders, (samples + 1,). */
static inline void fill_flat_surface(double edge_m, double dr_m, int64_t samples, double height_m, double cd, double cs,
                                     double sigma_rad, double *restrict weight, double *restrict nearness)
{
    for (int64_t j = 0; j < samples; j++) {
        const double distance = larger(edge_m + ((double)j + 0.5) * dr_m, LEAST_DISTANCE);
        weight[j] = reflectivity_at(smaller(1.0, height_m / distance), cd, cs, sigma_rad) * distance * distance;
    }
    for (int64_t j = 0; j <= samples; j++)
        nearness[j] = 1.0 / larger(edge_m + (double)j * dr_m, LEAST_DISTANCE);
}

/* Adds `weight` (bins,) times the change of `table`, the vertical pattern's sum, between `place` (bins + 1,). */
static inline void add_received(const double *restrict table, const double *restrict place, const double *restrict weight,
                             int64_t bins, double *restrict received, double *restrict out)
{
    for (int64_t k = 0; k <= bins; k++) {
        const int32_t node = (int32_t)place[k];
        received[k] = table[node] + (place[k] - node) * (table[node + 1] - table[node]);
    }
    for (int64_t k = 0; k < bins; k++)
        out[k] += weight[k] * fabs(received[k + 1] - received[k]);
}

/* The half plane of one bearing: the foot of the perpendicular from the sonar, and its elevation. */
typedef struct {
    double nearest_m, cosine, sine;
} FlatColumn;

/* One side of the perpendicular's foot: angles to it from `near` to `far`, up (`side` 1) or down (-1). The cosine of
   the angle is nearest / R. */
static inline Bins flat_branch(const FlatSurface *surface, const Grid *grid, FlatColumn column, double near, double far,
                               double side, double *out, int64_t plane_stride)
{
    if (!(near < far))
        return NO_BINS;
    const double high = cos(near), low = larger(cos(far), 1e-9), samples = (double)grid->samples;
    const int64_t first = node_at((column.nearest_m / high - grid->edge_m) / grid->dr_m, samples);
    const int64_t last = node_at((column.nearest_m / low - grid->edge_m) / grid->dr_m + 1.0, samples);
    if (first >= last)
        return NO_BINS;
    const double scale = 0.5 * (double)(grid->sum_nodes - 1), most = (double)grid->sum_nodes - 1.001;
    const double nearest = column.nearest_m, sine = column.sine, aside = side * column.cosine;
    const double *restrict nearness = surface->nearness + first;
    double *restrict place = surface->place;
    for (int64_t k = 0; k <= last - first; k++) {
        const double c = smaller(larger(nearest * nearness[k], low), high);
        place[k] = smaller(larger((sine * c + aside * sqrt(1.0 - c * c) + 1.0) * scale, 0.0), most);
    }
    for (int64_t plane = 0; plane < grid->planes; plane++)
        add_received(grid->vertical_sum + plane * grid->sum_nodes, place, surface->weight + first, last - first,
                  surface->received, out + plane * plane_stride + first);
    return (Bins){first, last};
}

/* Adds the plane's echo at one bearing, m2 per radian of bearing, between the elevations `low` and `high`, rad, to the
   rows `out`: one of `samples` numbers for each plane of beams, `plane_stride` apart. Returns the bins touched. */
static inline Bins surface_column(const FlatSurface *surface, const Grid *grid, double bearing_rad, double low,
                                  double high, double *out, int64_t plane_stride)
{
    const double *down = surface->down;
    const double along = down[0] * cos(bearing_rad) + down[1] * sin(bearing_rad), steep = hypot(along, down[2]);
    if (!(steep >= LEVEL))
        return NO_BINS;
    const double axis = atan2(-down[2], along);
    const FlatColumn column = {surface->height_m / steep, along / steep, -down[2] / steep};
    const double rise = smaller(high - axis, RIGHT), fall = smaller(axis - low, RIGHT);
    const Bins above = flat_branch(surface, grid, column, larger(low - axis, 0.0), rise, 1.0, out, plane_stride);
    const Bins below = flat_branch(surface, grid, column, larger(axis - high, 0.0), fall, -1.0, out, plane_stride);
    return both_bins(above, below);
}

#endif
