/* The smallest circle around points, as Python asks for it. */

#include "ods/pipeline/measure/circle/enclosing_circle.h"

KERNEL(smallest_circle, "f8[points,2] points, out f8[3] circle")
{
    const EnclosingCircle circle = smallest_circle_of(ARRAY(const Point, 0), SIZE(0, 0));
    double *out = ARRAY(double, 1);
    out[0] = circle.x, out[1] = circle.y, out[2] = circle.radius;
}
