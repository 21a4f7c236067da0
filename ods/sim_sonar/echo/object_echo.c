/* The mean echo of one object, by columns of bearing that just cover it (see object_echo.py). */

#include "ods/sim_sonar/echo/bodies/bodies.h"
#include "ods/sim_sonar/echo/surface/flat_surface.h"
#include "ods/sim_sonar/echo/rays/mixing.h"
#include "ods/sim_sonar/echo/rays/ray_budget.h"
#include "ods/sim_sonar/echo/surface/reflection.h"

/* Beam widths from a column within which beams receive it on its own; the others receive it with its neighbours. */
#define NEAR_WIDTHS 3.0
/* Bins under which a column's range counts as one. */
#define LEAST_SMEAR 0.5

/* An object, its rays, and what they have met; rows of `rays.cells` numbers, one a column. */
typedef struct {
    const Body *body;
    RayFan rays;
    double *ranges; /* m, FAR where it is not met first */
    double *echo;   /* gamma R^2, m2; of a plane nothing */
} Traced;

/* What may hide an object. */
typedef struct {
    const Body *bodies;
    const int64_t *rivals; /* numbers of bodies */
    int64_t rival_count;
    const double *limit; /* ranges, as Traced's, at which the sea-bed does */
} Occluders;

static bool is_hidden(const Occluders *occluders, double x, double y, double z, double distance)
{
    for (int64_t k = 0; k < occluders->rival_count; k++)
        if (hit(&occluders->bodies[occluders->rivals[k]], x, y, z).range_m < distance)
            return true;
    return false;
}

/* Sets ranges and echo of the ray through each cell of a column. */
static void trace_column(const Traced *object, const Occluders *occluders, int64_t column)
{
    const Body *body = object->body;
    const double *elevation = elevations_of(&object->rays, column), middle = middle_of(&object->rays, column);
    const double cos_bearing = cos(middle), sin_bearing = sin(middle);
    const int64_t begin = column * object->rays.cells;
    for (int64_t e = 0; e < object->rays.cells; e++) {
        const double upward = 0.5 * (elevation[e + 1] + elevation[e]), level = cos(upward);
        const double x = level * cos_bearing, y = level * sin_bearing, z = -sin(upward);
        const Hit met = hit(body, x, y, z);
        object->ranges[begin + e] = FAR;
        object->echo[begin + e] = 0.0;
        if (met.range_m >= occluders->limit[begin + e] || is_hidden(occluders, x, y, z, met.range_m))
            continue;
        object->ranges[begin + e] = met.range_m;
        if (body->kind != PLANE)
            object->echo[begin + e] =
                reflectivity_at(met.cosine, body->cd, body->cs, body->sigma_rad) * square(met.range_m);
    }
}

/* ---------------------------------------------------------------- columns of spheres and cylinders */

/* Where an echo lies about the range of a cell's middle, m. */
typedef struct {
    double begin, length;
} Slope;

/* Returns the range that cell `k` of `count`, `step` apart, spans, by its neighbours that are met. */
static double extent_of(const double *ranges, int64_t k, int64_t count, int64_t step)
{
    double total = 0.0;
    int neighbours = 0;
    for (int64_t other = k - 1; other <= k + 1; other += 2)
        if (other >= 0 && other < count && ranges[other * step] < FAR) {
            total += fabs(ranges[other * step] - ranges[k * step]);
            neighbours++;
        }
    return neighbours > 1 ? total / neighbours : total;
}

/* Returns the same as a slope, no farther than `slack` beyond its neighbours' ranges: at the rim of a cylinder's end,
   where the surface is bent, the end's slope gave an echo nearer than the nearest point of the body. */
static Slope slope_of(const double *ranges, int64_t k, int64_t count, int64_t step, double slack)
{
    const double half = 0.5 * extent_of(ranges, k, count, step);
    double begin = -half, end = half;
    if (k > 0 && k < count - 1 && ranges[(k - 1) * step] < FAR && ranges[(k + 1) * step] < FAR) {
        const double before = ranges[(k - 1) * step] - ranges[k * step];
        const double after = ranges[(k + 1) * step] - ranges[k * step];
        begin = larger(begin, smaller(smaller(before, after), 0.0) - slack);
        end = smaller(end, larger(larger(before, after), 0.0) + slack);
    }
    return (Slope){begin, end - begin};
}

/* Two boxes, folded. */
typedef struct {
    double wide, narrow;
} Trapezoid;

/* Returns the share of a trapezoid about 0 that lies below `x`. */
static double share_below(Trapezoid shape, double x)
{
    const double foot = 0.5 * (shape.wide + shape.narrow), shoulder = 0.5 * (shape.wide - shape.narrow);
    if (x <= -foot)
        return 0.0;
    if (x >= foot)
        return 1.0;
    if (x < -shoulder)
        return square(x + foot) / (2.0 * shape.wide * shape.narrow);
    if (x <= shoulder)
        return 0.5 + x / shape.wide;
    return 1.0 - square(foot - x) / (2.0 * shape.wide * shape.narrow);
}

/* Adds `power` to `bins` of `row` as a trapezoid about 0; the near edge of bin 0 lies at `edge_m`. */
static void spread(double *row, double power, Bins bins, double edge_m, double dr_m, Trapezoid shape)
{
    double before = share_below(shape, edge_m + (double)bins.first * dr_m);
    for (int64_t j = bins.first; j < bins.last; j++) {
        const double after = share_below(shape, edge_m + (double)(j + 1) * dr_m);
        row[j] += power * (after - before);
        before = after;
    }
}

/* Spreads the echo of one bearing's cells, m2 per radian of bearing, over `rows` (planes, samples). */
static Bins bent_column(double *rows, const Traced *object, int64_t column, const Grid *grid)
{
    const int64_t cells = object->rays.cells, columns = object->rays.columns;
    const double *elevation = elevations_of(&object->rays, column), dr_m = grid->dr_m;
    Bins all = NO_BINS;
    for (int64_t e = 0; e < cells; e++) {
        const double *ranges = object->ranges + column * cells, echo = object->echo[column * cells + e];
        if (echo == 0.0)
            continue;
        const Slope across = slope_of(object->ranges + e, column, columns, cells, dr_m);
        const Slope upward = slope_of(ranges, e, cells, 1, dr_m);
        const Trapezoid shape = {larger(larger(across.length, upward.length), 1e-6),
                                 larger(smaller(across.length, upward.length), 1e-7)};
        const double middle = ranges[e] + across.begin + upward.begin + 0.5 * (across.length + upward.length);
        const double edge_m = grid->edge_m - middle, foot = 0.5 * (shape.wide + shape.narrow);
        const Bins bins = {node_at((-foot - edge_m) / dr_m, (double)grid->samples),
                           node_at((foot - edge_m) / dr_m + 1.0, (double)grid->samples)};
        all = both_bins(all, bins);
        const double low = sin(elevation[e]), high = sin(elevation[e + 1]);
        for (int64_t plane = 0; plane < grid->planes; plane++) {
            const double power = echo * (high - low) * mean_two_way(grid, plane, low, high);
            spread(rows + plane * grid->samples, power, bins, edge_m, dr_m, shape);
        }
    }
    return all;
}

/* ---------------------------------------------------------------- columns of planes */

/* Returns `total`, whose nodes are the middles of bins and the first of them that of bin 0, at `place` in bins; it goes
   on by `below` a bin. */
static double sum_at(const double *total, int64_t last, double below, double place)
{
    const double where = place - 0.5;
    if (!(where > 0.0))
        return 0.0;
    if (where >= (double)last)
        return total[last] + below * (where - (double)last);
    const int32_t node = (int32_t)where;
    return total[node] + (where - node) * (total[node + 1] - total[node]);
}

/* Spreads what is in each bin evenly over `width` bins about its middle. `total`: bins + 1 numbers to work in. */
static void smear(double *row, int64_t bins, double width, double *total)
{
    /* the running integral, over bins, of what lies below the middle of each */
    double below = 0.0;
    total[0] = 0.0;
    for (int64_t j = 0; j < bins; j++) {
        below += row[j];
        total[j + 1] = total[j] + below;
        row[j] = 0.0;
    }
    for (double side = -1.0; side <= 1.0; side += 2.0) {
        double before = sum_at(total, bins, below, 0.5 * side * width);
        for (int64_t j = 0; j < bins; j++) {
            const double after = sum_at(total, bins, below, (double)j + 1.0 + 0.5 * side * width);
            row[j] += side * (after - before) / width;
            before = after;
        }
    }
}

/* Adds a plane's echo at one bearing, m2 per radian, to `rows` (planes, samples), which are zero.

   All runs of its visible cells are drawn at the middle of the column and smeared over the range that the column spans
   in the middle of the longest run: the column's own middle may be hidden. */
static Bins plane_column(double *rows, const FlatSurface *flat, const Traced *object, int64_t column, const Grid *grid)
{
    const int64_t cells = object->rays.cells, samples = grid->samples;
    const double *elevation = elevations_of(&object->rays, column), *ranges = object->ranges + column * cells;
    const double middle = middle_of(&object->rays, column);
    Bins bins = NO_BINS;
    int64_t longest = 0, seen = 0;
    for (int64_t e = 0; e < cells; e++) {
        const int64_t start = e;
        while (e < cells && ranges[e] < FAR)
            e++;
        if (e > start)
            bins = both_bins(bins, surface_column(flat, grid, middle, elevation[start], elevation[e], rows, samples));
        if (e - start > longest) {
            longest = e - start;
            seen = start + longest / 2;
        }
    }
    const double width = extent_of(object->ranges + seen, column, object->rays.columns, cells) / grid->dr_m;
    if (bins.first >= bins.last || width < LEAST_SMEAR)
        return bins;
    const int64_t reach = node_at(0.5 * width, (double)samples) + 2;
    bins = (Bins){larger_i(bins.first - reach, 0), smaller_i(bins.last + reach, samples)};
    for (int64_t plane = 0; plane < grid->planes; plane++)
        smear(rows + plane * samples + bins.first, bins.last - bins.first, width, flat->received);
    return bins;
}

/* Returns the plane in which a body lies. */
static FlatSurface surface_of(const Body *body, const Grid *grid)
{
    const double along = dot(body->axes[2], body->centre), height = fabs(along);
    const int64_t samples = grid->samples;
    double *down = SCRATCH(double, 3), *weight = SCRATCH(double, samples), *nearness = SCRATCH(double, samples + 1);
    for (int k = 0; k < 3; k++)
        down[k] = along < 0.0 ? -body->axes[2][k] : body->axes[2][k];
    fill_flat_surface(grid->edge_m, grid->dr_m, samples, height, body->cd, body->cs, body->sigma_rad, weight, nearness);
    return (FlatSurface){down, height, weight, nearness, SCRATCH(double, samples + 1), SCRATCH(double, samples + 1)};
}

/* ---------------------------------------------------------------- columns to beams */

/* Returns the end of the columns from `a` on that distant beams receive together; aside of all beams each is alone.

   Those of one beam width, counted from straight ahead: left and right are alike. */
static int64_t end_of_neighbours(const RayFan *rays, int64_t a, const Grid *grid)
{
    const double *bearing = rays->bearing, mine = trunc(middle_of(rays, a) / grid->beam_width_rad);
    int64_t end = a + 1;
    while (end < rays->columns && trunc(middle_of(rays, end) / grid->beam_width_rad) == mine) {
        if (bearing[a] < grid->bearing_rad[0] || bearing[end + 1] > grid->bearing_rad[grid->beams - 1])
            break;
        end++;
    }
    return end;
}

/* Returns how many beams lie before a bearing. */
static int64_t beams_before(const Grid *grid, double bearing_rad)
{
    int64_t low = 0, high = grid->beams;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        if (grid->bearing_rad[middle] < bearing_rad)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Adds one column's `rows` (planes, samples), per radian of bearing, to the beams from `first` to before `last`.
   `shares`: rad, of each beam, `step` apart. */
static void mix_column(double *image, const double *rows, Bins bins, const double *shares, int64_t step, int64_t first,
                       int64_t last, const Grid *grid)
{
    for (int64_t plane = 0; plane < grid->planes && bins.first < bins.last; plane++)
        for (int64_t beam = first; beam < last; beam++)
            add_share(image + (plane * grid->beams + beam) * grid->samples + bins.first,
                      rows + plane * grid->samples + bins.first, shares[beam * step], bins.last - bins.first);
}

/* Adds `rows` times `width` to `together`, both (planes, samples), and sets them to 0. */
static void gather(double *together, double *rows, Bins bins, double width, const Grid *grid)
{
    for (int64_t plane = 0; plane < grid->planes && bins.first < bins.last; plane++) {
        const int64_t begin = plane * grid->samples + bins.first;
        add_share(together + begin, rows + begin, width, bins.last - bins.first);
        memset(rows + begin, 0, (size_t)(bins.last - bins.first) * sizeof *rows);
    }
}

/* What the columns of one object are mixed with, and rows to work in, which are zero between two groups of columns. */
typedef struct {
    const Traced *object;
    const Grid *grid;
    const FlatSurface *flat;   /* of a plane */
    const double *shares;      /* (beams, columns) */
    double *rows, *together;   /* (planes, samples) of one column, and of a group of columns */
    double *far;               /* (beams,) */
} Mixer;

/* Adds the columns from `a` to before `end`: near beams receive each on its own, the others all together. */
static void add_group(double *image, const Mixer *mixer, int64_t a, int64_t end)
{
    const Traced *object = mixer->object;
    const Grid *grid = mixer->grid;
    const double *bearing = object->rays.bearing, reach = NEAR_WIDTHS * grid->beam_width_rad;
    const int64_t columns = object->rays.columns, low = beams_before(grid, bearing[a] - reach);
    const int64_t high = larger_i(low, beams_before(grid, bearing[end] + reach));
    Bins all = NO_BINS;
    for (int64_t column = a; column < end; column++) {
        const Bins bins = object->body->kind == PLANE ? plane_column(mixer->rows, mixer->flat, object, column, grid)
                                                      : bent_column(mixer->rows, object, column, grid);
        mix_column(image, mixer->rows, bins, mixer->shares + column, columns, low, high, grid);
        gather(mixer->together, mixer->rows, bins, bearing[column + 1] - bearing[column], grid);
        all = both_bins(all, bins);
    }
    for (int64_t beam = 0; beam < grid->beams; beam++) {
        mixer->far[beam] = 0.0;
        for (int64_t column = a; column < end; column++)
            mixer->far[beam] += mixer->shares[beam * columns + column];
        mixer->far[beam] /= bearing[end] - bearing[a];
    }
    mix_column(image, mixer->together, all, mixer->far, 1, 0, low, grid);
    mix_column(image, mixer->together, all, mixer->far, 1, high, grid->beams, grid);
    for (int64_t plane = 0; plane < grid->planes && all.first < all.last; plane++)
        memset(mixer->together + plane * grid->samples + all.first, 0, (size_t)(all.last - all.first) * sizeof(double));
}

/* Adds the mean echo, m2, of body `which` to `image` and sets the ranges at which its rays meet it (see
   object_echo.py). */
LONG_KERNEL(add_object, "out f8[:,:] image, " BODIES ", int which, i8[:] rivals, f8[fan_columns,cells] limit, " RAY_FAN
                        ", " GRID ", out f8[fan_columns,cells] ranges")
{
    const Occluders occluders = {ARRAY(const Body, 1), ARRAY(const int64_t, 3), SIZE(3, 0), ARRAY(const double, 4)};
    const Body *body = &occluders.bodies[INT(2)];
    const RayFan rays = ray_fan_from(arguments, 5);
    const Grid grid = grid_from(arguments, 8);
    const Traced object = {body, rays, ARRAY(double, 18), SCRATCH(double, rays.columns * rays.cells)};
    const FlatSurface flat = body->kind == PLANE ? surface_of(body, &grid) : (FlatSurface){0};
    double *shares = SCRATCH(double, grid.beams * rays.columns);
    const Mixer mixer = {
        .object = &object,
        .grid = &grid,
        .flat = &flat,
        .shares = shares,
        .rows = ZEROS(double, grid.planes * grid.samples),
        .together = ZEROS(double, grid.planes * grid.samples),
        .far = SCRATCH(double, grid.beams),
    };
    const bool fits = SIZE(0, 0) == grid.planes * grid.beams && SIZE(0, 1) == grid.samples && SIZE(4, 1) == rays.cells;
    if (!fits || rays.cells < 1)
        return;
    for (int64_t a = 0; a < rays.columns; a++)
        trace_column(&object, &occluders, a);
    shares_of(rays.bearing, rays.columns, &grid, INFINITY, shares);
    for (int64_t a = 0, end; a < rays.columns; a = end) {
        end = end_of_neighbours(&rays, a, &grid);
        add_group(ARRAY(double, 0), &mixer, a, end);
    }
}
