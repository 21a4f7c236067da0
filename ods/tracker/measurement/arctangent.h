/* An arctangent that the compiler turns into vector instructions, as it cannot do with atan2. */

#ifndef ODS_ARCTANGENT_H
#define ODS_ARCTANGENT_H

#include "kernel.h"

/* Returns the angle of the point (x, y), as atan2 does, right to 3e-16; 0 at the origin.

   Source: S. L. Moshier, Cephes Mathematical Library, atan.c: a rational function of tangents up to 0.66, greater ones
   turned by 45 and 90 degrees first. */
static inline double arctangent(double y, double x)
{
    const double across = fabs(y), along = fabs(x), least = smaller(along, across);
    const double most = larger(larger(along, across), NOT_ZERO);
    const bool is_steep = least > 0.66 * most;
    const double t = (is_steep ? least - most : least) / (is_steep ? least + most : most), z = t * t;
    const double low = (-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z - 7.500855792314704667340e1;
    const double p = (low * z - 1.228866684490136173410e2) * z - 6.485021904942025371773e1;
    const double high = ((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2;
    const double q = (high * z + 4.853903996359136964868e2) * z + 1.945506571482613964425e2;
    double angle = t + t * (z * p / q) + (is_steep ? 0.78539816339744830962 : 0.0);
    angle = across > along ? 1.57079632679489661923 - angle : angle;
    angle = x < 0.0 ? 3.14159265358979323846 - angle : angle;
    return copysign(angle, y);
}

#endif
