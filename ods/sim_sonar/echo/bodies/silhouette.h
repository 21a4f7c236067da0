/* The outline of a body as the sonar sees it: its bearings, and its elevations at one bearing.

   The half plane of a bearing cuts a convex body in one piece, and so rays at that bearing meet it between two
   elevations. */

#ifndef ODS_SILHOUETTE_H
#define ODS_SILHOUETTE_H

#include "ods/sim_sonar/echo/bodies/bodies.h"
#include "ods/sim_sonar/echo/rays/fan.h"

/* Marks of one body, at most. */
#define MOST_MARKS 4

/* Least and greatest elevation, rad; least above greatest: there is none. */
typedef struct {
    double low, high;
} Span;

#define NOTHING ((Span){1.0, -1.0})

/* The half plane of a bearing in a body's own axes: where the sonar is, unit vectors ahead and up. */
typedef struct {
    double origin[3], ahead[3], up[3];
} Cut;

/* Where the half plane meets a plane of the body's: its place nearest to the sonar, m ahead and up, and the way on, a
   unit vector. */
typedef struct {
    double ahead, up, way_ahead, way_up;
} CutLine;

/* A coordinate in the body's axes at a line's place, and its change along the line. */
typedef struct {
    double at, change;
} Coordinate;

static inline Cut cut_of(const Body *body, double bearing_rad)
{
    const double cosine = cos(bearing_rad), sine = sin(bearing_rad);
    Cut cut;
    for (int k = 0; k < 3; k++) {
        cut.origin[k] = -dot(body->axes[k], body->centre);
        cut.ahead[k] = body->axes[k][0] * cosine + body->axes[k][1] * sine;
        cut.up[k] = -body->axes[k][2];
    }
    return cut;
}

/* Tells whether the half plane is parallel to the planes on which the body's third coordinate is the same. */
static inline bool is_parallel(const Cut *cut)
{
    return hypot(cut->ahead[2], cut->up[2]) < PARALLEL;
}

/* Returns where the body's third coordinate is `at`; the half plane must not be parallel to that plane. */
static inline CutLine line_at(const Cut *cut, double at)
{
    const double a = cut->ahead[2], b = cut->up[2], norm = hypot(a, b), share = (at - cut->origin[2]) / (norm * norm);
    return (CutLine){a * share, b * share, -b / norm, a / norm};
}

static inline Coordinate along_line(const Cut *cut, CutLine line, int axis)
{
    const double ahead = cut->ahead[axis], up = cut->up[axis];
    const double at = cut->origin[axis] + ahead * line.ahead + up * line.up;
    return (Coordinate){at, ahead * line.way_ahead + up * line.way_up};
}

static inline Span with_elevation(Span span, double up, double ahead)
{
    const double elevation = atan2(up, ahead);
    return (Span){smaller(span.low, elevation), larger(span.high, elevation)};
}

static inline Span sphere_span(const Cut *cut, double radius)
{
    const double along = -dot(cut->origin, cut->ahead), up = -dot(cut->origin, cut->up);
    const double inside = radius * radius - (dot(cut->origin, cut->origin) - along * along - up * up);
    const double distance = hypot(along, up);
    if (inside <= 0.0 || distance * distance <= inside)
        return NOTHING;
    const double middle = atan2(up, along), half = asin(sqrt(inside) / distance);
    return (Span){larger(middle - half, -RIGHT), smaller(middle + half, RIGHT)};
}

/* Returns least and greatest elevation of the rays that touch a cylinder's side; (RIGHT, -RIGHT) for none. */
static inline Span touching_span(const Cut *cut, double radius, double half)
{
    const double *o = cut->origin, *u = cut->ahead, *v = cut->up;
    const double over_u = o[0] * u[1] - o[1] * u[0], over_v = o[0] * v[1] - o[1] * v[0], inside = radius * radius;
    const double a = over_v * over_v - inside * (v[0] * v[0] + v[1] * v[1]);
    const double b = over_u * over_v - inside * (u[0] * v[0] + u[1] * v[1]);
    const double c = over_u * over_u - inside * (u[0] * u[0] + u[1] * u[1]);
    const double rest = b * b - a * c, ahead = fabs(a);
    Span span = {RIGHT, -RIGHT};
    if (!(rest > 0.0))
        return span;
    for (double side = -1.0; side <= 1.0; side += 2.0) {
        const double up = copysign(1.0, a) * (side * sqrt(rest) - b);
        const double dx = ahead * u[0] + up * v[0], dy = ahead * u[1] + up * v[1], dz = ahead * u[2] + up * v[2];
        const double share = -(o[0] * dx + o[1] * dy) / larger(dx * dx + dy * dy, NOT_ZERO);
        if (share > 0.0 && fabs(o[2] + share * dz) <= half)
            span = with_elevation(span, up, ahead);
    }
    return span;
}

/* The ends are where rays touch the side, or on the rims. */
static inline Span cylinder_span(const Cut *cut, double radius, double half)
{
    Span span = touching_span(cut, radius, half);
    if (is_parallel(cut))
        return span;
    bool above = false, below = false;
    for (double side = -1.0; side <= 1.0; side += 2.0) {
        const CutLine line = line_at(cut, side * half);
        const Coordinate x = along_line(cut, line, 0), y = along_line(cut, line, 1);
        const double middle = x.at * x.change + y.at * y.change;
        const double inside = middle * middle - (x.at * x.at + y.at * y.at - radius * radius);
        for (double end = -1.0; end <= 1.0 && inside > 0.0; end += 2.0) {
            const double step = end * sqrt(inside) - middle;
            const double ahead = line.ahead + step * line.way_ahead, up = line.up + step * line.way_up;
            if (ahead > 0.0)
                span = with_elevation(span, up, ahead);
            above = above || (ahead <= 0.0 && up > 0.0);
            below = below || (ahead <= 0.0 && up < 0.0);
        }
    }
    if (span.low < span.high)
        span = (Span){below ? -RIGHT : span.low, above ? RIGHT : span.high};
    return span;
}

/* Clips the way along a line, from `low` to `high`, to where a coordinate lies within `half`; false: nowhere. */
static inline bool clip_to(Coordinate coordinate, double half, Span *way)
{
    if (fabs(coordinate.change) < PARALLEL)
        return fabs(coordinate.at) <= half;
    const double one = (-half - coordinate.at) / coordinate.change, other = (half - coordinate.at) / coordinate.change;
    *way = (Span){larger(way->low, smaller(one, other)), smaller(way->high, larger(one, other))};
    return true;
}

/* Clips the line that the half plane cuts from the plane. */
static inline Span plane_span(const Cut *cut, double half_width, double half_height, double farthest_m)
{
    if (is_parallel(cut))
        return NOTHING;
    const CutLine line = line_at(cut, 0.0);
    const double reach = square(farthest_m) - square(line.ahead) - square(line.up);
    if (!(reach > 0.0))
        return NOTHING;
    Span way = {-sqrt(reach), sqrt(reach)};
    if (!clip_to(along_line(cut, line, 0), half_width, &way) || !clip_to(along_line(cut, line, 1), half_height, &way))
        return NOTHING;
    /* nothing of what is behind */
    if (line.way_ahead > PARALLEL)
        way.low = larger(way.low, -line.ahead / line.way_ahead);
    else if (line.way_ahead < -PARALLEL)
        way.high = smaller(way.high, -line.ahead / line.way_ahead);
    else if (line.ahead < 0.0)
        return NOTHING;
    if (!(way.low < way.high))
        return NOTHING;
    const double one = atan2(line.up + way.low * line.way_up, larger(line.ahead + way.low * line.way_ahead, 0.0));
    const double other = atan2(line.up + way.high * line.way_up, larger(line.ahead + way.high * line.way_ahead, 0.0));
    return (Span){smaller(one, other), larger(one, other)};
}

/* Returns the elevations of a body at one bearing, within half a turn; NOTHING: it is not there.

   Of a plane, what is nearer than `farthest_m`. The body may hide the lower part from view, never the ends. */
static inline Span elevation_span(const Body *body, double bearing_rad, double farthest_m)
{
    const Cut cut = cut_of(body, bearing_rad);
    if (body->kind == SPHERE)
        return sphere_span(&cut, body->half[0]);
    if (body->kind == CYLINDER)
        return cylinder_span(&cut, body->half[0], body->half[2]);
    return plane_span(&cut, body->half[0], body->half[1], farthest_m);
}

/* Sets x and y to the corners of a plane, seen from above. */
static inline void corners_of(const Body *body, double *x, double *y)
{
    for (int k = 0; k < MOST_MARKS; k++) {
        const double across = k < 2 ? -body->half[0] : body->half[0], up = k % 2 == 0 ? -body->half[1] : body->half[1];
        x[k] = body->centre[0] + across * body->axes[0][0] + up * body->axes[1][0];
        y[k] = body->centre[1] + across * body->axes[0][1] + up * body->axes[1][1];
    }
}

/* Sets x and y to the places, seen from above, where bearings touch a cylinder's rims; (-1, 0) if they do not. */
static inline void rims_of(const Body *body, double *x, double *y)
{
    const double radius = body->half[0], (*axes)[3] = body->axes;
    const double ux = radius * axes[0][0], uy = radius * axes[0][1], vx = radius * axes[1][0], vy = radius * axes[1][1];
    for (int k = 0; k < MOST_MARKS; k++) {
        const double side = k < 2 ? -body->half[2] : body->half[2], way = k % 2 == 0 ? -1.0 : 1.0;
        const double middle_x = body->centre[0] + side * axes[2][0], middle_y = body->centre[1] + side * axes[2][1];
        const double a = middle_x * vy - middle_y * vx, b = middle_y * ux - middle_x * uy, c = uy * vx - ux * vy;
        const double norm = hypot(a, b);
        x[k] = -1.0;
        y[k] = 0.0;
        if (norm > fabs(c)) {
            const double turn = atan2(b, a) + way * acos(c / norm);
            x[k] = middle_x + ux * cos(turn) + vx * sin(turn);
            y[k] = middle_y + uy * cos(turn) + vy * sin(turn);
        }
    }
}

static inline void sort(double *values, int count)
{
    for (int k = 1; k < count; k++)
        for (int j = k; j > 0 && values[j] < values[j - 1]; j--) {
            const double before = values[j - 1];
            values[j - 1] = values[j];
            values[j] = before;
        }
}

/* Sets `marks` to the bearings, rad, rising, at which a body in the sonar's frame begins, has corners or rims, and
   ends; all round when they cannot be found. Returns how many. */
static inline int bearing_marks(const Body *body, double *marks)
{
    double x[MOST_MARKS], y[MOST_MARKS];
    marks[0] = -PI;
    marks[1] = PI;
    if (body->kind == SPHERE) {
        const double level = hypot(body->centre[0], body->centre[1]);
        if (level > body->half[0]) {
            const double bearing = atan2(body->centre[1], body->centre[0]), across = asin(body->half[0] / level);
            marks[0] = bearing - across;
            marks[1] = bearing + across;
        }
        return 2;
    }
    if (body->kind == CYLINDER)
        rims_of(body, x, y);
    else
        corners_of(body, x, y);
    bool ahead = true, starboard = true, port = true;
    for (int k = 0; k < MOST_MARKS; k++) {
        ahead = ahead && x[k] > 0.0;
        starboard = starboard && y[k] > 0.0;
        port = port && y[k] < 0.0;
    }
    if (!ahead && !starboard && !port)
        return 2;
    for (int k = 0; k < MOST_MARKS; k++)
        marks[k] = atan2(y[k], x[k]);
    sort(marks, MOST_MARKS);
    return MOST_MARKS;
}

#endif
