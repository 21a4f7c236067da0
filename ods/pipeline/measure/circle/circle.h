/* The circle that stands for an echo's body, with the beam's width taken out.

   Across the beams, an echo is wider than its object, because a beam of -3 dB width w also receives its surroundings with
   a Gaussian directivity. In the outermost beam an object's edge at distance x inside or outside the beam's axis leaves
   the share q = Phi(x / s), s = w / 2.355, of the intensity that the beams further in show: so the level of that beam
   shows where the edge is. */

#ifndef ODS_CIRCLE_H
#define ODS_CIRCLE_H

#include "ods/pipeline/measure/circle/depth.h"
#include "ods/pipeline/measure/circle/enclosing_circle.h"
#include "ods/pipeline/measure/circle/outline.h"

/* Phi(x) is 1 / (1 + exp(-1.702 x)) to within 0.01. */
#define LOGIT_OF_PROBIT 1.702
/* Exponent of the outermost beam's share: a round body is darker at its edge [SSIE eq. 3] even without a beam's blur.
   1 fits flat discs, 0.6 spheres. */
#define LIMB 0.8
/* Widest object, in units of a cell, that is seen in one beam alone. */
#define LONE_BEAM 0.7
/* Echoes narrower than this many beam widths show no shape: they are taken for round, */
#define RESOLVED 2.0
/* and for no wider than this many times their depth: a sphere's front is seen to 0.3 to 0.6 of its radius. */
#define WIDEST_FRONT 3.0
/* Largest standard deviation of an echo's place across the line of sight: of what is small in widths of the beam, of a
   flat front in its own width. */
#define BLURRED 0.15
#define FLAT 0.5
/* Up to this radius the centre is the middle of what shines, as small bodies often shine all over; from twice as much
   on it is a radius behind the near edge. */
#define SMALL_M 0.3

/* In the sonar's plane. */
typedef struct {
    double range_m, bearing_rad, radius_m;
} Circle;

/* What an echo shows of its body's shape: fields of circle.Shape. */
typedef struct {
    double whole, roundness, long_m, wide_m, blur_m, beams, contrast, beside_m;
} Shape;

/* How loud an echo is. */
typedef struct {
    const double *beam; /* intensity of each of its beams */
    double peak;        /* highest level in multiples of the background, */
    double contrast;    /* and of the mean of the lower ends of its runs: over a rough sea-bed those are higher */
} Crest;

/* An echo across the line of sight, rad, with the beam's width taken out. */
typedef struct {
    double left, right;
    double blur; /* -3 dB width of the beam */
} Width;

/* Returns the largest standard deviation of an echo's place across the line of sight, m.

   Of what shines with speckle, the middle is known to its width over its level; a flat front may be seen in part. */
static inline double largest_beside_m(double roundness, double wide, double blur, double peak)
{
    return distance_of(BLURRED * blur, (roundness / peak + (1.0 - roundness) * FLAT) * wide);
}

/* Returns how far an object reaches beyond the axis of the outermost beam of its echo, rad; negative inside.

   beam, bearing: intensity and axis of the outermost of `count` beams; step: to the next one. cell: its width, rad. */
static inline double overhang(const double *beam, const double *bearing, int64_t count, int64_t step, double blur,
                              double cell)
{
    if (count == 1)
        return 0.5 * LONE_BEAM * cell;
    double inner = 0.0;
    for (int64_t k = 1; k < count; k++) {
        inner = larger(beam[step * k], inner);
        if (fabs(bearing[step * k] - bearing[0]) >= 0.75 * blur)
            break;
    }
    const double share = held(pow(beam[0] / larger(1e-30, inner), LIMB), 1e-6, 0.999);
    const double outside = (1.0 / FULL_WIDTH) * blur * log(share / (1.0 - share)) / LOGIT_OF_PROBIT;
    return smaller(0.5 * cell, larger(-larger(cell, blur), outside));
}

/* Returns from where to where an echo reaches. beam: intensity of each of its beams. */
static inline Width width_of(const double *beam, int64_t low, int64_t high, const FanTable *fan)
{
    const double *bearing = fan->bearing_rad, *borders = fan->borders_rad;
    const int64_t count = high - low + 1;
    const double blur = fan->beam_width_rad[(low + high) / 2];
    const double left = overhang(beam, bearing + low, count, 1, blur, borders[low + 1] - borders[low]);
    const double right = overhang(beam + count - 1, bearing + high, count, -1, blur, borders[high + 1] - borders[high]);
    return (Width){bearing[low] - left, bearing[high] + right, blur};
}

/* Fills points (4 runs,) with the corners of all runs in the sonar's plane, ahead and to starboard, m.

   Corners on the left of `centre` are moved `left` rad towards it, the others `right` rad, and never across it. */
static inline void outline(const Region *region, Ends ends, const double *borders, double left, double right,
                           double centre, Point *points)
{
    int64_t known = -1; /* the border that `corner` is at: each is one of two beams */
    Point corner = {1.0, 0.0};
    for (int64_t i = 0; i < region->count; i++)
        for (int64_t side = 0; side < 2; side++) {
            if (known != region->runs[i].beam + side) {
                known = region->runs[i].beam + side;
                const double border = borders[known];
                const double angle = border < centre ? smaller(centre, border + left) : larger(centre, border - right);
                corner = (Point){cos(angle), sin(angle)};
            }
            points[4 * i + 2 * side] = (Point){ends.near_m[i] * corner.x, ends.near_m[i] * corner.y};
            points[4 * i + 2 * side + 1] = (Point){ends.far_m[i] * corner.x, ends.far_m[i] * corner.y};
        }
}

/* Returns c of the parabola y = a + b x + c x^2 that fits best, by polynomials orthogonal on the points x. */
static inline double square_term(const double *x, const double *y, int64_t count)
{
    double mean = 0.0, second = 0.0, third = 0.0;
    for (int64_t i = 0; i < count; i++)
        mean += x[i] / (double)count;
    for (int64_t i = 0; i < count; i++) {
        const double away = x[i] - mean;
        second += away * away;
        third += away * away * away;
    }
    double product = 0.0, squares = 0.0;
    for (int64_t i = 0; i < count; i++) {
        const double away = x[i] - mean;
        const double term = away * away - away * third / second - second / (double)count;
        product += y[i] * term;
        squares += term * term;
    }
    return product / larger(1e-30, squares);
}

/* Returns 1 for an echo with a convex front, 0 for a flat one, by the curvature of a parabola through the front.

   The curvature times the half width is 0.6 for a sphere of which 40 deg to each side are seen, at least 0.2 when the
   beams blur it, and within +-0.1 for a wall with speckle. */
static inline double roundness_of(const Region *region, const double *near_m, const double *bearing, double centre,
                                  double half_width)
{
    double *across = SCRATCH(double, region->count); /* position of each beam's front, from left to right */
    double *ahead = SCRATCH(double, region->count);
    int64_t count = 0;
    double nearest = INFINITY; /* of the runs of one beam */
    for (int64_t i = 0; i < region->count; i++) {
        const int32_t beam = region->runs[i].beam;
        nearest = smaller(near_m[i], nearest);
        if (i + 1 == region->count || region->runs[i + 1].beam != beam) {
            const double angle = bearing[beam] - centre;
            across[count] = nearest * sin(angle), ahead[count] = nearest * cos(angle);
            count++;
            nearest = INFINITY;
        }
    }
    if (count < 3)
        return 0.0;
    const double curvature = 2.0 * square_term(across, ahead, count);
    return held((curvature * half_width - 0.05) / 0.2, 0.0, 1.0);
}

/* Returns 1 for an echo as deep as it is wide, as that of a whole body is, and 0 for one half as deep.

   A width that the beam does not resolve is that much wider, and proves little: at least 0.5. */
static inline double as_deep_as_wide(double long_m, double wide_m, double blur_m, bool resolved)
{
    if (!resolved)
        wide_m = sqrt(larger(1e-6, wide_m * wide_m - blur_m * blur_m));
    const double alike = held(5.0 * (long_m / larger(1e-3, wide_m) - 0.5), 0.0, 1.0);
    return resolved ? alike : 0.5 + 0.5 * alike;
}

/* Returns the smallest circle around the echo's outline, with its beams' width taken out: `across` rad are left. */
static inline EnclosingCircle around(const Region *region, Ends ends, const double *borders, double centre,
                                     double across)
{
    Point *points = SCRATCH(Point, 4 * region->count);
    const double left = centre - 0.5 * across - borders[region->low];
    const double right = borders[region->high + 1] - (centre + 0.5 * across);
    outline(region, ends, borders, left, right, centre, points);
    return smallest_circle_of(points, 4 * region->count);
}

/* Returns the circle of an echo, and fills in its outline and what it shows of the body's shape. */
static inline Circle circle_of(const Region *region, Ends ends, const Depth *depth, Crest crest, const FanTable *fan,
                               Outline *outline, Shape *shape)
{
    const double long_m = depth->far_m - depth->near_m, middle_m = 0.5 * (depth->near_m + depth->far_m);
    const Width width = width_of(crest.beam, region->low, region->high, fan);
    const double wide = larger(0.0, width.right - width.left), centre = 0.5 * (width.left + width.right);
    const bool resolved = wide >= RESOLVED * width.blur && region->high - region->low >= 2;
    const double across = resolved ? wide : smaller(WIDEST_FRONT * long_m / larger(fan->dr_m, middle_m), wide);
    const EnclosingCircle found = around(region, ends, fan->borders_rad, centre, across);
    const double blur_m = width.blur * middle_m, wide_m = wide * middle_m;
    *outline = outline_of(region, ends, fan->borders_rad, centre, across);
    const double whole = depth->whole * as_deep_as_wide(long_m, wide_m, blur_m, resolved);
    double roundness = 1.0, radius = found.radius;
    if (resolved)
        roundness = larger(whole, roundness_of(region, ends.near_m, fan->bearing_rad, centre, 0.5 * across * middle_m));
    radius *= 1.0 + roundness / pow(crest.contrast, 3.0); /* of a weak front the highlights show */
    radius = larger(0.5 * fan->dr_m, radius + whole * (0.5 * long_m - radius));
    double distance = distance_of(found.x, found.y);
    distance += roundness * held(radius / SMALL_M - 1.0, 0.0, 1.0) * (depth->near_m + radius - distance);
    *shape = (Shape){
        .whole = whole, .roundness = roundness, .long_m = long_m, .wide_m = wide_m, .blur_m = blur_m,
        .beams = (double)(region->high - region->low + 1), .contrast = crest.contrast,
        .beside_m = largest_beside_m(roundness, larger(blur_m, wide_m), blur_m, crest.peak),
    };
    return (Circle){distance, atan2(found.y, found.x), radius};
}

#endif
