/* How far an echo that the fan's edge cuts off may lie from the middle of what it is of. */

#ifndef ODS_CUT_OFF_H
#define ODS_CUT_OFF_H

#include "kernel.h"

/* Returns the largest variance, m^2, that the place of an echo of an object of this radius can have.

   What is seen of a body lies inside its circle: so far at most off its middle. Of an echo that is not `cut` this says
   nothing. */
static inline double farthest_off(double cut, double radius, double radius_variance)
{
    return cut != 0.0 ? radius * radius + radius_variance : INFINITY;
}

#endif
