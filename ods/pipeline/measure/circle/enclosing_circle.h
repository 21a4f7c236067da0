/* Smallest enclosing circles. */

#ifndef ODS_ENCLOSING_CIRCLE_H
#define ODS_ENCLOSING_CIRCLE_H

#include "kernel.h"

/* Relative; a point this little outside a circle counts as on it. */
#define SLACK 1e-9

typedef struct {
    double x, y;
} Point;

typedef struct {
    double x, y, radius;
} EnclosingCircle;

static inline double distance_of(double dx, double dy)
{
    return sqrt(dx * dx + dy * dy);
}

/* Returns the circle through three points, or the one with diameter ab when b is c; its radius is inf when in line. */
static inline EnclosingCircle circle_through(Point a, Point b, Point c)
{
    if (b.x == c.x && b.y == c.y)
        return (EnclosingCircle){0.5 * (a.x + b.x), 0.5 * (a.y + b.y), 0.5 * distance_of(a.x - b.x, a.y - b.y)};
    const double bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
    const double cross = 2.0 * (bx * cy - by * cx);
    const double b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    if (fabs(cross) < 1e-12 * (b2 + c2))
        return (EnclosingCircle){0.0, 0.0, INFINITY};
    const double ux = (cy * b2 - by * c2) / cross, uy = (bx * c2 - cx * b2) / cross;
    return (EnclosingCircle){a.x + ux, a.y + uy, distance_of(ux, uy)};
}

static inline bool holds_all(EnclosingCircle circle, const Point *points, int count)
{
    const double limit = square(circle.radius * (1.0 + SLACK) + 1e-12);
    for (int i = 0; i < count; i++)
        if (square(points[i].x - circle.x) + square(points[i].y - circle.y) > limit)
            return false;
    return true;
}

/* Returns the smallest circle of 2 to 4 points; the points that carry it are moved to the front and counted. They are
   in rising order, so none is overwritten too early. */
static inline EnclosingCircle circle_of_support(Point *points, int *count)
{
    EnclosingCircle best = {points[0].x, points[0].y, INFINITY};
    int first = 0, second = 0, third = 0;
    for (int i = 0; i < *count; i++)
        for (int j = i + 1; j < *count; j++)
            for (int k = j; k < *count; k++) { /* k == j stands for the pair alone */
                const EnclosingCircle circle = circle_through(points[i], points[j], points[k]);
                if (circle.radius < best.radius && holds_all(circle, points, *count))
                    best = circle, first = i, second = j, third = k;
            }
    points[0] = points[first], points[1] = points[second], points[2] = points[third];
    *count = third == second ? 2 : 3;
    return best;
}

/* Returns the smallest circle that holds all points, at least one.

   The circle is grown: the point farthest outside joins the at most three points that carry the circle, and the
   smallest circle of those four takes over, until none is outside (D. J. Elzinga, D. W. Hearn, Transportation Science
   6(4), 1972). The radius grows at every step, so it ends; a handful of steps is usual. */
static inline EnclosingCircle smallest_circle_of(const Point *points, int64_t count)
{
    Point support[4] = {points[0]};
    EnclosingCircle circle = {points[0].x, points[0].y, 0.0};
    int carrying = 1;
    for (int64_t step = 0; step < 10 * count + 10; step++) {
        double reach = square(circle.radius * (1.0 + SLACK) + 1e-12);
        int64_t farthest = -1;
        for (int64_t i = 0; i < count; i++) {
            const double away = square(points[i].x - circle.x) + square(points[i].y - circle.y);
            if (away > reach)
                farthest = i, reach = away;
        }
        if (farthest < 0)
            break;
        support[carrying++] = points[farthest];
        circle = circle_of_support(support, &carrying);
    }
    return circle;
}

#endif
