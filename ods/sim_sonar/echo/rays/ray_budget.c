/* How many rays each object needs, and which objects may hide which. */

#include "ods/sim_sonar/echo/bodies/silhouette.h"
#include "ods/sim_sonar/sonar/grid.h"

/* Cells across an object, and in its facets' lobe per radian of its width, over the root of the allowed error. */
#define CELLS 3.3
#define LOBE_CELLS 1.089
/* Columns of a cylinder or plane, and in its facets' lobe, at least, over the root of the allowed error. */
#define FEWEST 3.0
#define LOBE 0.5
/* Samples by which the range may change from column to column, over that root. */
#define SHIFT 50.0
/* Parts of a column whose range changes by more. */
#define MAX_PARTS 16
/* Cells of elevation of a plane, per radian, over those of a whole sphere: they show what hides it. */
#define PLANE_LOBES 1.6
/* Columns of endless planes that only side lobes receive are wider by this. */
#define ASIDE 2.0
/* Share of a width that is next to none. */
#define TINY 1e-9
/* Error that a faint object's own echo may have, over that of the image. */
#define LOOSEST 4.0

/* Returns about how much a sphere or cylinder counts in the rms of the image. */
static double weight_of(const Body *body, const Grid *grid)
{
    const double radius = sqrt(body->half[0] * larger(body->half[0], body->half[2]));
    const double distance = larger(sqrt(dot(body->centre, body->centre)), radius);
    const double sine = -body->centre[2] / distance, reach = radius / distance;
    double received = 0.0;
    for (int64_t plane = 0; plane < grid->planes; plane++)
        received += mean_two_way(grid, plane, larger(sine - reach, -1.0), smaller(sine + reach, 1.0));
    const double samples = larger(1.0, radius / grid->dr_m) * larger(1.0, 2.0 * reach / grid->beam_width_rad);
    return (body->cd + body->cs) * received * radius * radius / sqrt(samples);
}

/* Sets the relative errors that the echoes of bodies in the sonar's frame may have; together they make `max_error`.

   An echo that fills n samples with the power a counts for a / sqrt(n) in the image's rms, its rays cost as one over
   its error: least work is where the error goes as that to the power -2/3. Planes keep `max_error`. */
KERNEL(shares_of_error, BODIES ", " GRID ", float max_error, out f8[bodies] errors")
{
    const Body *bodies = ARRAY(const Body, 0);
    const Grid grid = grid_from(arguments, 1);
    const double max_error = FLOAT(11);
    double *errors = ARRAY(double, 12), *weight = ZEROS(double, SIZE(0, 0)), total = 0.0, parts = 0.0;
    for (int64_t k = 0; k < SIZE(0, 0); k++) {
        if (bodies[k].kind != PLANE)
            weight[k] = weight_of(&bodies[k], &grid);
        total += square(weight[k]);
        parts += pow(weight[k], 2.0 / 3.0);
    }
    for (int64_t k = 0; k < SIZE(0, 0); k++) {
        const double share = sqrt(total / parts) / pow(weight[k], 2.0 / 3.0);
        errors[k] = weight[k] > 0.0 ? max_error * smaller(share, LOOSEST) : max_error;
    }
}

/* Returns the range of the middle of what a bearing sees of a body, m; FAR when there is nothing. */
static double middle_range(const Body *body, double bearing_rad)
{
    const Span span = elevation_span(body, bearing_rad, FAR);
    if (span.low >= span.high)
        return FAR;
    const double upward = 0.5 * (span.low + span.high), level = cos(upward);
    return hit(body, level * cos(bearing_rad), level * sin(bearing_rad), -sin(upward)).range_m;
}

/* Returns the next whole number, at most `most`; what is over one but for rounding is that one. */
static int32_t whole_above(double wanted, int64_t most)
{
    return node_at(ceil(wanted - TINY), (double)most);
}

/* Returns the widest column that the beams' pattern allows, rad. */
static double widest_column(const Grid *grid, double max_error)
{
    return grid->beam_width_rad * smaller(0.5, 3.0 * sqrt(max_error));
}

/* A body's columns as they are made. */
typedef struct {
    double *bearing; /* borders, at most `most` + 1 */
    int64_t most, used;
    double widest;
    double greatest_change; /* of range from column to column, m */
} Columns;

/* Adds the columns from `begin` to `end`, `parts` of them. */
static void add_columns(Columns *columns, double begin, double end, int64_t parts)
{
    for (int64_t k = 1; k <= parts && columns->used < columns->most; k++)
        columns->bearing[++columns->used] = begin + (end - begin) * (double)k / (double)parts;
}

/* Adds the columns between two marks `part` apart. `aside`: only side lobes receive them; `kept`: columns that others
   need. */
static void add_between_marks(Columns *columns, const Body *body, double start, double part, bool aside, int64_t kept)
{
    const int32_t count = whole_above(part / (aside ? ASIDE * columns->widest : columns->widest), columns->most);
    double before = middle_range(body, start + TINY * part);
    for (int32_t k = 0; k < count; k++) {
        const double begin = start + part * k / count, end = start + part * (k + 1) / count;
        const double after = middle_range(body, end - TINY * part);
        int64_t parts = 1;
        if (before < FAR && after < FAR && !aside)
            parts += node_at(fabs(after - before) / columns->greatest_change, MAX_PARTS);
        const int64_t left = columns->most - columns->used - (count - k) - kept;
        add_columns(columns, begin, end, larger_i(1, smaller_i(smaller_i(parts, MAX_PARTS), left)));
        before = after;
    }
}

/* Sets borders of columns of a cylinder or plane: at its corners, and closer where its range changes fast. */
static void set_uneven(Columns *columns, const Body *body, const double *found, int count, const Grid *grid,
                       double max_error)
{
    const double root = sqrt(max_error), first = found[0], last = found[count - 1], span = last - first;
    const double west = grid->bearing_rad[0] - grid->lit_beyond_rad;
    const double east = grid->bearing_rad[grid->beams - 1] + grid->lit_beyond_rad;
    const bool endless = bounding_radius(body) > (double)grid->samples * grid->dr_m;
    double marks[MOST_MARKS + 2];
    memcpy(marks, found, (size_t)count * sizeof *marks);
    marks[count++] = smaller(larger(west, first), last);
    marks[count++] = smaller(larger(east, first), last);
    sort(marks, count);
    columns->widest = smaller(span * root / FEWEST, body->sigma_rad * root / LOBE);
    columns->widest = smaller(columns->widest, widest_column(grid, max_error));
    columns->widest = larger(columns->widest, span / (double)(columns->most - count));
    columns->greatest_change = SHIFT * grid->dr_m * root;
    columns->bearing[0] = marks[0];
    for (int mark = 0; mark + 1 < count; mark++) {
        const double start = marks[mark], end = marks[mark + 1], part = end - start;
        /* upper and lower corners of an upright plane are one mark but for rounding: no column between them */
        if (!(part > TINY * span))
            continue;
        const bool aside = endless && (start >= east || end <= west);
        const int32_t after = whole_above((last - end) / columns->widest, columns->most);
        add_between_marks(columns, body, start, part, aside, after + count);
    }
}

/* Sets the borders of the columns of a body between the first and last of its marks; returns how many columns. */
static int64_t set_columns(double *bearing, int64_t most, const Body *body, const double *marks, int count,
                           const Grid *grid, double max_error)
{
    if (body->kind != SPHERE) {
        Columns columns = {bearing, most, 0, 0.0, 0.0};
        set_uneven(&columns, body, marks, count, grid, max_error);
        return columns.used;
    }
    const double root = sqrt(max_error), low = marks[0], high = marks[count - 1];
    const double widths = (high - low) / widest_column(grid, max_error);
    const double wanted = larger(CELLS / root, larger(LOBE_CELLS / root / body->sigma_rad, widths));
    const int32_t cells = (int32_t)larger_i(2, whole_above(wanted, most));
    for (int32_t k = 0; k <= cells; k++)
        bearing[k] = k * ((high - low) / cells) + low;
    return cells;
}

/* Sets the borders of the cells of elevation in each column, up to the range `end_m`, evenly from the body's lower to
   its upper end at the column's middle, (columns, cells + 1), all 0 where nothing of it is; returns how many cells. */
static int64_t set_elevations(double *elevation, int64_t most, const Body *body, const double *bearing, int64_t columns,
                              double end_m, double max_error)
{
    double tallest = -INFINITY, lobes = LOBE_CELLS / sqrt(max_error) / body->sigma_rad;
    Span *spans = SCRATCH(Span, columns);
    for (int64_t a = 0; a < columns; a++) {
        spans[a] = elevation_span(body, 0.5 * (bearing[a] + bearing[a + 1]), end_m);
        tallest = larger(tallest, spans[a].high - spans[a].low);
    }
    if (body->kind == PLANE)
        lobes *= tallest * PLANE_LOBES;
    const int32_t cells = (int32_t)larger_i(1, whole_above(larger(CELLS / sqrt(max_error), lobes), most));
    for (int64_t a = 0; a < columns; a++) {
        const bool seen = spans[a].low < spans[a].high;
        const double low = seen ? spans[a].low : 0.0, step = seen ? (spans[a].high - spans[a].low) / cells : 0.0;
        for (int32_t e = 0; e <= cells; e++)
            elevation[a * (cells + 1) + e] = e * step + low;
    }
    return cells;
}

/* Sets the rays that hold what the sonar can see of a body, fine enough for a relative error of `max_error`: borders of
   their columns and of the cells of elevation in each, and `size`: columns and cells; 0 when nothing of it can be seen.
   Returns the range, m, beyond which nothing of the body lies. */
KERNEL_FLOAT(ray_fan_of, BODIES ", int which, " GRID ", float max_error, "
                         "out f8[:] bearing, out f8[:] elevation, out i8[2] size")
{
    const Body *body = &ARRAY(const Body, 0)[INT(1)];
    const Grid grid = grid_from(arguments, 2);
    const double max_error = FLOAT(12), end_m = grid.edge_m + (double)grid.samples * grid.dr_m;
    const double distance = sqrt(dot(body->centre, body->centre)), radius = bounding_radius(body);
    const int64_t most = SIZE(13, 0) - 1;
    int64_t *size = ARRAY(int64_t, 15);
    double marks[MOST_MARKS], *bearing = ARRAY(double, 13);
    const int count = bearing_marks(body, marks);
    for (int k = 0; k < count; k++)
        marks[k] = smaller(larger(marks[k], -RIGHT), RIGHT);
    size[0] = size[1] = 0;
    if (distance - radius > end_m || !(marks[0] < marks[count - 1]))
        return 0.0;
    size[0] = set_columns(bearing, most, body, marks, count, &grid, max_error);
    size[1] = set_elevations(ARRAY(double, 14), most, body, bearing, size[0], end_m, max_error);
    return distance + radius;
}

/* Returns the angle between the directions of two places, rad; half a turn when one is the sonar's own. */
static double angle_between(const double *one, const double *other)
{
    const double product = sqrt(dot(one, one)) * sqrt(dot(other, other));
    return product > 0.0 ? acos(smaller(larger(dot(one, other) / product, -1.0), 1.0)) : PI;
}

/* Tells of bodies in the sonar's frame whether the second may stand before the first. */
KERNEL(rivals_of, BODIES ", out b1[bodies,bodies] rivals")
{
    const Body *bodies = ARRAY(const Body, 0);
    const int64_t count = SIZE(0, 0);
    double *distance = SCRATCH(double, count), *radius = SCRATCH(double, count), *half = SCRATCH(double, count);
    for (int64_t k = 0; k < count; k++) {
        distance[k] = sqrt(dot(bodies[k].centre, bodies[k].centre));
        radius[k] = bounding_radius(&bodies[k]);
        half[k] = distance[k] > radius[k] ? asin(radius[k] / distance[k]) : PI;
    }
    for (int64_t k = 0; k < count; k++)
        for (int64_t other = 0; other < count; other++) {
            const bool before = other != k && distance[other] - radius[other] < distance[k] + radius[k];
            ARRAY(bool, 1)[k * count + other] =
                before && angle_between(bodies[k].centre, bodies[other].centre) < half[k] + half[other];
        }
}
