/* Two tracks of one object: stray echoes of a silent one, or part of a larger one (stitching.py). */

#ifndef ODS_STITCHING_H
#define ODS_STITCHING_H

#include "ods/tracker/track/tracks.h"

/* Some of n objects, by their numbers. */
typedef struct {
    const int64_t *numbers;
    int64_t count;
} Some;

/* Where n objects are: (2 or more, n) north and east, m, and (n,) radii. */
typedef struct {
    const double *north, *east, *radius;
} Circles;

/* Tells whether the middles of two objects are horizontally nearer to each other than `reach`. */
static inline bool are_near(const Circles *circles, int64_t i, int64_t j, double reach)
{
    const double north = circles->north[i] - circles->north[j], east = circles->east[i] - circles->east[j];
    return reach > 0.0 && square(north) + square(east) < square(reach);
}

/* Tells whether young object i may be stray echoes of one of the `missed`, objects not seen in this image.

   Their circles touch, and the old one was seen since the young one began, so that the young one does not continue it:
   until an image shows both, they are one. */
static inline bool is_duplicate(int64_t i, Some missed, const History *history, const Circles *circles)
{
    for (int64_t k = 0; k < missed.count; k++) {
        const int64_t j = missed.numbers[k];
        if (history->last[j] >= history->born[i] && are_near(circles, i, j, circles->radius[i] + circles->radius[j]))
            return true;
    }
    return false;
}

/* Tells whether the middle of object i lies inside the circle of one of the `others`. */
static inline bool is_covered(int64_t i, Some others, const Circles *circles)
{
    for (int64_t k = 0; k < others.count; k++)
        if (are_near(circles, i, others.numbers[k], circles->radius[others.numbers[k]]))
            return true;
    return false;
}

#endif
