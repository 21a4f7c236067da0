/* A rough sea-bed's echo: columns of steps over its facets, marched outwards from the sonar.

   A column is a thin slice of the fan at one bearing. Going out, each step is a short piece of sea-bed of which the
   sonar sees what rises above all before it (the horizon). The piece returns gamma S^2 R^2 over the elevations that it
   fills (eq. 5; R^2 turns solid angle into area), spread over the ranges that it spans. gamma is that of the facet's own
   slope. Far away, where a column grows wider than the sea-bed's structure, it is split in two, which both inherit its
   horizon. */

#include "ods/sim_sonar/sea_bed/rough.h"
#include "ods/sim_sonar/echo/bodies/bodies.h"
#include "ods/sim_sonar/echo/rays/interpolation.h"
#include "ods/sim_sonar/echo/rays/mixing.h"
#include "ods/sim_sonar/echo/rays/ray_budget.h"
#include "ods/sim_sonar/echo/bodies/shadow.h"

/* Least cosine between a step and the ray that is distinguished from 0: there the whole step lies at one range. */
#define STEEPEST 0.02
/* Least cosine between the sonar's axis and a facet's normal, times the normal's length, at which it is a slope. */
#define LEAST_LEAN 0.02
/* A column is split at most this many times. */
#define MOST_SPLITS 5
/* Places at which the change from one column to the next is sampled. */
#define BLEND 4
/* Columns that are drawn before they are mixed into the beams. */
#define TOGETHER 8

/* The echo of the land at the steps of a trace, (steps,) each. */
typedef struct {
    double *reach;   /* range, m */
    double *sine;    /* of elevation */
    double *gamma;
    double *density; /* lit area per metre of range: R^2 d(sine) / dR */
} LandEcho;

static void reflect(const RoughBed *bed, const Trace *trace, Land land, LandEcho echo)
{
    const double upright = 1.0 / trace->stretch, lean_x = bed->turn[0][2], lean_y = bed->turn[1][2];
    const double *restrict all_ahead = land.ahead, *restrict all_up = land.up;
    const double *restrict slope_x = land.slope_x, *restrict slope_y = land.slope_y;
    double *restrict reach = echo.reach, *restrict sine = echo.sine;
    double *restrict gamma = echo.gamma, *restrict density = echo.density;
#pragma GCC ivdep /* `restrict` of variables is lost where a function is inlined */
    for (int64_t k = 0; k < land.steps; k++) {
        const double x = slope_x[k], y = slope_y[k], ahead = all_ahead[k], up = all_up[k];
        const double distance = larger(sqrt(ahead * ahead + up * up), 1e-9);
        const double rise = trace->down + x * trace->toward.x + y * trace->toward.y;
        const double slope = rise / larger(upright + x * lean_x + y * lean_y, LEAST_LEAN);
        const double facing = larger(ahead * slope - up, 0.0);
        const double aside = x * trace->across[0] + y * trace->across[1] + trace->across[2];
        const double normal = 1.0 + x * x + y * y;
        const double tilted = larger(0.0, normal - aside * aside) / (normal * (1.0 + slope * slope));
        reach[k] = distance;
        sine[k] = up / distance;
        gamma[k] = facing / distance * sqrt(tilted);
        density[k] = ahead * facing / larger(fabs(ahead + up * slope), STEEPEST * distance);
    }
    for (int64_t k = 0; k < land.steps; k++)
        gamma[k] = interpolate(bed->gamma, bed->gamma_nodes, gamma[k]);
}

/* A visible piece of sea-bed: of its two ends the ranges, sines of elevation, gamma and density; and the share of it
   that no object hides. */
typedef struct {
    double near, far, low, high, gamma_near, gamma_far, density_near, density_far, seen;
} Piece;

/* Sets `pieces` to what is seen along a trace above the horizon, a sine of elevation, which is moved on; returns their
   number. */
static int64_t see(LandEcho echo, int64_t steps, double *horizon, Piece *pieces)
{
    const double *reach = echo.reach, *sine = echo.sine, *gamma = echo.gamma, *density = echo.density;
    int64_t count = 0;
    for (int64_t k = 1; k < steps; k++) {
        const double low = larger(sine[k - 1], *horizon);
        if (!(sine[k] > low))
            continue;
        *horizon = sine[k];
        const double rest = (sine[k] - low) / (sine[k] - sine[k - 1]);
        pieces[count++] = (Piece){
            .near = reach[k] - rest * (reach[k] - reach[k - 1]),
            .far = reach[k],
            .low = low,
            .high = sine[k],
            .gamma_near = gamma[k] - rest * (gamma[k] - gamma[k - 1]),
            .gamma_far = gamma[k],
            .density_near = density[k] - rest * (density[k] - density[k - 1]),
            .density_far = density[k],
            .seen = 1.0,
        };
    }
    return count;
}

/* Spreads `power` over the bins of `row` from place `one` to place `other`, in a density that changes linearly as the
   two given do. */
static void ramp(double *restrict row, int64_t samples, double power, double one, double other, double at_one,
                 double at_other)
{
    const bool is_back = other < one;
    const double begin = is_back ? other : one, finish = larger(is_back ? one : other, begin + 1e-6);
    double first_density = is_back ? at_other : at_one, last_density = is_back ? at_one : at_other;
    if (!(first_density + last_density > 0.0))
        first_density = last_density = 1.0;
    const double per_bin = 1.0 / (finish - begin);
    const double unit = 2.0 * power * per_bin / (first_density + last_density);
    const double rise = (last_density - first_density) * unit * per_bin, start = first_density * unit - rise * begin;
    const double low = larger(begin, 0.0), high = smaller(finish, (double)samples);
    if (!(low < high))
        return;
    const int64_t first = (int64_t)low, last = smaller_i((int64_t)high, samples - 1);
    if (first == last) {
        row[first] += (high - low) * (start + rise * 0.5 * (low + high));
        return;
    }
    row[first] += ((double)(first + 1) - low) * (start + rise * 0.5 * (low + (double)(first + 1)));
    row[last] += (high - (double)last) * (start + rise * 0.5 * (high + (double)last));
    for (int64_t j = first + 1; j < last; j++)
        row[j] += start + rise * ((double)j + 0.5);
}

/* Adds the echo of `pieces` as received by one plane to `row` (samples,). */
static void fill(double *row, const Piece *pieces, int64_t count, int64_t plane, const Grid *grid)
{
    const double per_bin = 1.0 / grid->dr_m, *vertical = grid->vertical + plane * grid->vertical_nodes;
    for (int64_t k = 0; k < count; k++) {
        const Piece *piece = &pieces[k];
        const double near = piece->near, far = piece->far, low = piece->low, high = piece->high;
        const double first = piece->gamma_near * interpolate(vertical, grid->vertical_nodes, 0.5 + 0.5 * low);
        const double second = piece->gamma_far * interpolate(vertical, grid->vertical_nodes, 0.5 + 0.5 * high);
        const double one = piece->density_near, other = piece->density_far, middle = 0.5 * (near + far);
        /* gamma and density change linearly: the mean of their product is more than the product of their means */
        double power = 0.5 * (first + second) * middle * middle * (high - low);
        power += (second - first) * (other - one) * (far - near) / 12.0;
        if (power > 0.0)
            ramp(row, grid->samples, piece->seen * power, (near - grid->edge_m) * per_bin,
                 (far - grid->edge_m) * per_bin, first * one, second * other);
    }
}

/* What all columns of an image share, and what they are computed in. */
typedef struct {
    const RoughBed *bed;
    const Grid *grid;
    const Detail *detail;
    const Shade *shades;
    int64_t shade_count;
    MeanShade *on_column; /* (shade_count,) */
    Piece *pieces;        /* (steps,) */
    Land land;
    LandEcho echo;
    double *drawn; /* (planes, TOGETHER, samples) m2 per radian of bearing, zero */
    double *sum;   /* (planes, samples) of a zone's columns, zero */
} March;

/* Draws the echo of the column between two bearings as number `place` of those drawn; `horizon` is moved on. Returns the
   bins touched. */
static Bins draw_column(const March *march, double west, double east, double *horizon, int64_t place)
{
    const Grid *grid = march->grid;
    const Trace trace = trace_of(march->bed, 0.5 * (west + east));
    survey(march->bed, &trace, march->land);
    reflect(march->bed, &trace, march->land, march->echo);
    const int64_t count = see(march->echo, march->land.steps, horizon, march->pieces);
    const int64_t hiding = shades_on(march->shades, march->shade_count, west, east, march->on_column);
    double nearest = FAR, farthest = 0.0;
    for (int64_t k = 0; k < count; k++) {
        Piece *piece = &march->pieces[k];
        if (hiding > 0)
            piece->seen = visible_share(march->on_column, hiding, piece->low, piece->high,
                                        0.5 * (piece->near + piece->far));
        nearest = smaller(nearest, smaller(piece->near, piece->far));
        farthest = larger(farthest, larger(piece->near, piece->far));
    }
    for (int64_t plane = 0; plane < grid->planes; plane++)
        fill(march->drawn + (plane * TOGETHER + place) * grid->samples, march->pieces, count, plane, grid);
    if (count == 0)
        return NO_BINS;
    const double samples = (double)grid->samples;
    const int64_t first = node_at((nearest - grid->edge_m) / grid->dr_m, samples);
    return (Bins){first, larger_i(node_at((farthest - grid->edge_m) / grid->dr_m + 1.0, samples), first)};
}

/* Adds the columns drawn, number `column` and so on of `columns`, to the beams and to the sum of all; then they are zero
   again. `shares` (beams, columns). */
static void mix_drawn(const March *march, double *image, int64_t column, int64_t count, Bins bins, const double *shares,
                      int64_t columns)
{
    const Grid *grid = march->grid;
    const int64_t samples = grid->samples, width = bins.last - bins.first;
    for (int64_t plane = 0; plane < grid->planes && width > 0; plane++) {
        double *drawn = march->drawn + plane * TOGETHER * samples + bins.first;
        for (int64_t beam = 0; beam < grid->beams; beam++) {
            double *row = image + (plane * grid->beams + beam) * samples + bins.first;
            for (int64_t k = 0; k < count; k++)
                if (shares[beam * columns + column + k] != 0.0)
                    add_share(row, drawn + k * samples, shares[beam * columns + column + k], width);
        }
        for (int64_t k = 0; k < count; k++) {
            add_share(march->sum + plane * samples + bins.first, drawn + k * samples, 1.0, width);
            memset(drawn + k * samples, 0, (size_t)width * sizeof *drawn);
        }
    }
}

/* Adds the mean of all `columns`, as far as beams do not receive them one by one, to the image; then the sum is zero. */
static void mix_mean(const March *march, double *image, Bins bins, const double *shares, int64_t columns)
{
    const Grid *grid = march->grid;
    const int64_t samples = grid->samples, width = bins.last - bins.first;
    const double whole = pattern_width(grid);
    for (int64_t beam = 0; beam < grid->beams && width > 0; beam++) {
        double received = 0.0;
        for (int64_t a = 0; a < columns; a++)
            received += shares[beam * columns + a];
        for (int64_t plane = 0; plane < grid->planes; plane++)
            add_share(image + (plane * grid->beams + beam) * samples + bins.first,
                      march->sum + plane * samples + bins.first, (whole - received) / (double)columns, width);
    }
    memset(march->sum, 0, (size_t)(grid->planes * samples) * sizeof *march->sum);
}

/* Adds a zone's echo, m2, to the image: a ring of the sea-bed in which all columns are equally wide. `bearing`
   (columns + 1,): their borders; `horizon` (columns,): the sine of the elevation up to which each is filled. */
static void add_zone(const March *march, double *image, const double *bearing, int64_t columns, double *horizon)
{
    const Grid *grid = march->grid;
    double *shares = SCRATCH(double, grid->beams * columns);
    blended_shares(bearing, columns, grid, march->detail->reach, BLEND, shares);
    Bins all = NO_BINS;
    for (int64_t c = 0; c < columns; c += TOGETHER) {
        const int64_t count = smaller_i(TOGETHER, columns - c);
        Bins bins = NO_BINS;
        for (int64_t k = 0; k < count; k++)
            bins = both_bins(bins, draw_column(march, bearing[c + k], bearing[c + k + 1], &horizon[c + k], k));
        mix_drawn(march, image, c, count, bins, shares, columns);
        all = both_bins(all, bins);
    }
    mix_mean(march, image, all, shares, columns);
}

/* Returns `count` + 1 even borders. */
static double *even_borders(double low, double high, int64_t count)
{
    double *borders = SCRATCH(double, count + 1);
    const double step = (high - low) / (double)count;
    for (int64_t k = 0; k < count; k++)
        borders[k] = (double)k * step + low;
    borders[count] = high;
    return borders;
}

/* Returns how many of the rising `values` are not above `most`. */
static int64_t count_up_to(const double *values, int64_t count, double most)
{
    int64_t found = 0;
    while (found < count && values[found] <= most)
        found++;
    return found;
}

/* Adds the rings, from the sonar outwards; each has twice the columns of the one before. `ahead`: the ends of all
   steps. */
static void add_zones(March *march, double *image, double scale_m, const double *ahead, int64_t steps)
{
    const Grid *grid = march->grid;
    const double low = larger(grid->bearing_rad[0] - grid->lit_beyond_rad, -PI);
    const double high = smaller(grid->bearing_rad[grid->beams - 1] + grid->lit_beyond_rad, PI);
    const int64_t coarsest = node_at(ceil((high - low) / grid->beam_width_rad), 1e6);
    int64_t start = 0, columns = 1;
    double *horizon = (double[1]){-2.0};
    for (int split = 0; split <= MOST_SPLITS && start < steps - 1 && coarsest > 0; split++) {
        const int64_t count = coarsest << split;
        const double widest = march->detail->spacing * scale_m * (double)count / (high - low);
        const int64_t end = split == MOST_SPLITS ? steps - 1 : count_up_to(ahead, steps, widest) - 1;
        if (end <= start)
            continue;
        double *inherited = SCRATCH(double, count);
        for (int64_t c = 0; c < count; c++)
            inherited[c] = horizon[c / (count / columns)];
        march->land.ahead = ahead + start;
        march->land.steps = end - start + 1;
        add_zone(march, image, even_borders(low, high, count), count, inherited);
        horizon = inherited;
        columns = count;
        start = end;
    }
}

/* Tells whether tables that are looked up have what that needs. */
static bool is_whole(const RoughBed *bed, const Grid *grid)
{
    return bed->rows > 0 && bed->columns > 0 && bed->gamma_nodes > 1 && grid->beams > 0 && grid->vertical_nodes > 1;
}

/* Adds the mean echo, m2, of the sea-bed to the image, less what `shades` hide. `scale_m`: the length over which the
   echo changes. */
LONG_KERNEL(add_rough_bed, "out f8[:,:] image, " ROUGH_BED ", " GRID ", float scale_m, " SHADES ", " DETAIL)
{
    double *image = ARRAY(double, 0);
    const RoughBed bed = rough_bed_from(arguments, 1);
    const Grid grid = grid_from(arguments, 10);
    const Detail detail = detail_from(arguments, 22);
    if (!is_whole(&bed, &grid) || SIZE(0, 0) != grid.planes * grid.beams || SIZE(0, 1) != grid.samples)
        return;
    const double height = -bed.sonar_m[2], farthest = grid.edge_m + (double)grid.samples * grid.dr_m;
    const int64_t steps = steps_ahead(height, FLOAT(20), farthest, &detail, NULL);
    double *ahead = SCRATCH(double, steps);
    steps_ahead(height, FLOAT(20), farthest, &detail, ahead);
    March march = {
        .bed = &bed,
        .grid = &grid,
        .detail = &detail,
        .shades = ARRAY(const Shade, 21),
        .shade_count = SIZE(21, 0),
        .on_column = SCRATCH(MeanShade, SIZE(21, 0)),
        .pieces = SCRATCH(Piece, steps),
        .land = land_of(ahead, steps),
        .echo = {SCRATCH(double, steps), SCRATCH(double, steps), SCRATCH(double, steps), SCRATCH(double, steps)},
        .drawn = ZEROS(double, grid.planes * TOGETHER * grid.samples),
        .sum = ZEROS(double, grid.planes * grid.samples),
    };
    add_zones(&march, image, FLOAT(20), ahead, steps);
}

/* Sets the ranges and sines of elevation, (steps,), of the land at the steps of a trace. */
static void sight(Land land, double *restrict reach, double *restrict sine)
{
    const double *restrict ahead = land.ahead, *restrict up = land.up;
#pragma GCC ivdep
    for (int64_t k = 0; k < land.steps; k++) {
        reach[k] = larger(sqrt(ahead[k] * ahead[k] + up[k] * up[k]), 1e-9);
        sine[k] = up[k] / reach[k];
    }
}

/* Sets `out` (cells,) to the ranges at which rays of rising sines of elevation, `aim`, meet the land; FAR beyond its
   last step. */
static void meet(const double *reach, const double *sine, int64_t steps, const double *aim, int64_t cells, double *out)
{
    double past = 0.0, before = -1.0;
    int64_t e = 0;
    for (int64_t k = 0; k < steps && e < cells; k++) {
        for (; e < cells && aim[e] < sine[k]; e++) {
            const double share = aim[e] > before ? (aim[e] - before) / (sine[k] - before) : 0.0;
            out[e] = past + share * (reach[k] - past);
        }
        past = reach[k];
        before = sine[k];
    }
    for (; e < cells; e++)
        out[e] = FAR;
}

/* The ranges, FAR where there is none, at which rays meet the sea-bed nearer than `farthest_m`. Cells so close in
   bearing that the sea-bed is the same share one trace. */
LONG_KERNEL(rough_ranges,
            ROUGH_BED ", " RAY_FAN ", float scale_m, float within_m, " DETAIL ", out f8[fan_columns,:] ranges")
{
    const RoughBed bed = rough_bed_from(arguments, 0);
    const RayFan rays = ray_fan_from(arguments, 9);
    const Detail detail = detail_from(arguments, 14);
    if (bed.rows <= 0 || bed.columns <= 0 || SIZE(21, 1) != rays.cells)
        return;
    const double height = -bed.sonar_m[2], coarse = detail.spacing * FLOAT(12) / FLOAT(13);
    const int64_t steps = steps_ahead(height, FLOAT(12), FLOAT(13), &detail, NULL);
    double *ahead = SCRATCH(double, steps);
    steps_ahead(height, FLOAT(12), FLOAT(13), &detail, ahead);
    const Land land = land_of(ahead, steps);
    double *aim = SCRATCH(double, rays.cells), *reach = SCRATCH(double, steps), *sine = SCRATCH(double, steps);
    for (int64_t a = 0, end; a < rays.columns; a = end) {
        end = a + 1;
        while (end < rays.columns && rays.bearing[end + 1] - rays.bearing[a] <= coarse)
            end++;
        const Trace trace = trace_of(&bed, 0.5 * (rays.bearing[a] + rays.bearing[end]));
        survey(&bed, &trace, land);
        sight(land, reach, sine);
        for (int64_t column = a; column < end; column++) {
            const double *elevation = elevations_of(&rays, column);
            for (int64_t e = 0; e < rays.cells; e++)
                aim[e] = sin(0.5 * (elevation[e + 1] + elevation[e]));
            meet(reach, sine, steps, aim, rays.cells, ARRAY(double, 21) + column * rays.cells);
        }
    }
}
