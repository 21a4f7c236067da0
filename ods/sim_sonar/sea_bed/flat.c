/* A flat sea-bed's echo: columns in closed form, and what lies between them. */

#include "ods/sim_sonar/echo/bodies/bodies.h"
#include "ods/sim_sonar/echo/surface/flat_surface.h"
#include "ods/sim_sonar/echo/rays/mixing.h"
#include "ods/sim_sonar/echo/rays/ray_budget.h"
#include "ods/sim_sonar/echo/bodies/shadow.h"

/* A bearing's echo is computed at no more places than so many a beam. */
#define MOST_PARTS 4

/* The echo at bearings evenly from the first to the last beam: (parts + 1, planes, samples), m2 per radian of bearing;
   one bearing when the bed is level. */
typedef struct {
    double *echo;
    int64_t parts;
} BedColumns;

/* Returns the bins of one plane's column, number k. */
static double *column_of(const BedColumns *columns, const Grid *grid, int64_t k, int64_t plane)
{
    return columns->echo + (k * grid->planes + plane) * grid->samples;
}

/* Returns the bed's echo. From one bearing to the next the elevation of the sea-bed changes by at most `lean` radians,
   so that what lies between is linear. */
static BedColumns columns_of(const FlatSurface *bed, const Grid *grid, double lean)
{
    const double tilt = hypot(bed->down[0], bed->down[1]), first = grid->bearing_rad[0];
    const double span = grid->bearing_rad[grid->beams - 1] - first;
    BedColumns columns = {.parts = 0};
    if (tilt > LEVEL)
        columns.parts = node_at(ceil(tilt * span / lean), (double)(MOST_PARTS * grid->beams));
    columns.echo = ZEROS(double, (columns.parts + 1) * grid->planes * grid->samples);
    for (int64_t k = 0; k <= columns.parts; k++) {
        const double bearing = first + span * (double)k / (double)larger_i(columns.parts, 1);
        surface_column(bed, grid, bearing, -RIGHT, RIGHT, column_of(&columns, grid, k, 0), grid->samples);
    }
    return columns;
}

/* Sets `bins` of `out` to the echo of one plane at one bearing. */
static void blend(const BedColumns *columns, const Grid *grid, double bearing_rad, int64_t plane, Bins bins,
                  double *restrict out)
{
    const double first = grid->bearing_rad[0], span = larger(grid->bearing_rad[grid->beams - 1] - first, 1e-9);
    const double place = smaller(larger((bearing_rad - first) / span, 0.0), 1.0) * (double)columns->parts;
    const int64_t k = node_at(place, (double)larger_i(columns->parts - 1, 0));
    const double share = place - (double)k;
    const double *restrict low = column_of(columns, grid, k, plane);
    const double *restrict high = column_of(columns, grid, smaller_i(k + 1, columns->parts), plane);
    for (int64_t j = bins.first; j < bins.last; j++)
        out[j] = low[j] + share * (high[j] - low[j]);
}

/* Adds the sea-bed's mean echo, m2, to the image; it varies little across a beam. */
static void add_bed(double *image, const BedColumns *columns, const Grid *grid)
{
    const double width = pattern_width(grid);
    const Bins all = {0, grid->samples};
    double *column = SCRATCH(double, grid->samples);
    for (int64_t plane = 0; plane < grid->planes; plane++)
        for (int64_t beam = 0; beam < grid->beams; beam++) {
            if (beam == 0 || columns->parts > 0)
                blend(columns, grid, grid->bearing_rad[beam], plane, all, column);
            add_share(image + (plane * grid->beams + beam) * grid->samples, column, width, grid->samples);
        }
}

/* Returns the range, FAR where there is none, of the sea-bed at a bearing and the sine of an elevation. */
static double meet(const FlatSurface *bed, double bearing_rad, double sine)
{
    const double level = sqrt(larger(0.0, 1.0 - sine * sine));
    const double along = bed->down[0] * cos(bearing_rad) + bed->down[1] * sin(bearing_rad);
    const double sinking = along * level - bed->down[2] * sine;
    return sinking * FAR > bed->height_m ? bed->height_m / sinking : FAR;
}

/* Takes out of the image what one shade hides of the sea-bed; `column` (planes, samples) and `shares` (beams,) are to
   work in. */
static void hide(double *image, const FlatSurface *bed, const BedColumns *columns, const Grid *grid, const Shade *shade,
                 double reach, double *column, double *shares)
{
    const double border[2] = {shade->west, shade->east}, middle = 0.5 * (shade->west + shade->east);
    const double near = meet(bed, middle, shade->low), far = meet(bed, middle, shade->high);
    const double begin = larger((near - grid->edge_m) / grid->dr_m, 0.0);
    const double finish = smaller((far - grid->edge_m) / grid->dr_m, (double)grid->samples);
    if (!(begin < finish))
        return;
    const Bins bins = {(int64_t)begin, smaller_i((int64_t)finish + 1, grid->samples)};
    for (int64_t plane = 0; plane < grid->planes; plane++) {
        double *row = column + plane * grid->samples;
        blend(columns, grid, middle, plane, bins, row);
        row[bins.first] *= smaller((double)bins.first + 1.0, finish) - begin;
        if (bins.last - 1 > bins.first)
            row[bins.last - 1] *= larger(0.0, finish - (double)(bins.last - 1));
    }
    shares_of(border, 1, grid, reach, shares);
    for (int64_t beam = 0; beam < grid->beams; beam++)
        shares[beam] = -shares[beam];
    mix_columns(image, column, 1, bins, shares, grid);
}

/* Adds the sea-bed's echo, m2, to the image, less what `shades` hide of it; `lean`, `reach`: see `Detail`. */
LONG_KERNEL(add_flat_bed, "out f8[:,:] image, " FLAT_SURFACE ", " GRID ", " SHADES ", float lean, float reach")
{
    double *image = ARRAY(double, 0);
    const Grid grid = grid_from(arguments, 5);
    if (SIZE(0, 0) != grid.planes * grid.beams || SIZE(0, 1) != grid.samples || SIZE(3, 0) < grid.samples ||
        SIZE(4, 0) <= grid.samples || grid.beams == 0)
        return;
    const FlatSurface bed = flat_surface_from(arguments, 1);
    const BedColumns columns = columns_of(&bed, &grid, FLOAT(16));
    double *column = SCRATCH(double, grid.planes * grid.samples), *shares = SCRATCH(double, grid.beams);
    add_bed(image, &columns, &grid);
    for (int64_t k = 0; k < SIZE(15, 0); k++)
        hide(image, &bed, &columns, &grid, ARRAY(const Shade, 15) + k, FLOAT(17), column, shares);
}

/* The ranges, FAR where there is none, at which rays meet the sea-bed. */
KERNEL(flat_ranges, FLAT_SURFACE ", " RAY_FAN ", out f8[fan_columns,:] ranges")
{
    const FlatSurface bed = {.down = ARRAY(double, 0), .height_m = FLOAT(1)};
    const RayFan rays = ray_fan_from(arguments, 4);
    for (int64_t a = 0; a < rays.columns; a++) {
        const double *elevation = elevations_of(&rays, a), bearing = middle_of(&rays, a);
        double *ranges = ARRAY(double, 7) + a * SIZE(7, 1);
        for (int64_t e = 0; e < smaller_i(rays.cells, SIZE(7, 1)); e++)
            ranges[e] = meet(&bed, bearing, sin(0.5 * (elevation[e + 1] + elevation[e])));
    }
}
