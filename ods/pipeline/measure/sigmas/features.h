/* The numbers, without units, that show how well an echo's circle is known (features.py lists them).

   Each is held to what echoes of bodies have: beyond, the law (laws.npz) says what it says at the border. */

#ifndef ODS_FEATURES_H
#define ODS_FEATURES_H

#include "ods/pipeline/measure/circle/circle.h"
#include "ods/pipeline/measure/echo.h"

/* Widths of a point; nothing is taken to be shorter or narrower. */
#define LEAST_EXTENT 0.25

/* Fills values with the features of an echo, of which levels, extents and circle are filled in, in the order
   of features.Features. point_m: width of a point along the line of sight; dr_m: the columns' spacing;
   room: how many fit. */
static inline void find_features(const Echo *echo, const Depth *depth, const Shape *shape, double point_m, double dr_m,
                                 double *filled, int64_t room)
{
    const double least = LEAST_EXTENT * point_m;
    const double long_m = larger(least, shape->long_m), wide_m = larger(least, shape->wide_m);
    const double radius = larger(0.5 * least, echo->radius_m), blur_m = shape->blur_m;
    const double values[] = {
        held((depth->middle - 0.5) / 0.1, -2.0, 2.0),
        shape->whole,
        shape->roundness,
        held(log(long_m / point_m), -1.5, 4.0),
        held(log(radius / point_m), -2.5, 4.0),
        held(log(larger(0.5 * least, echo->range_m - echo->near_m) / radius), -1.5, 1.0),
        held(log(long_m / wide_m), -2.5, 2.5),
        square(wide_m) / (square(wide_m) + square(blur_m)),
        held(log(larger(least, blur_m) / point_m), -1.5, 3.0),
        log(smaller(30.0, shape->beams)),
        held(log(larger(0.1 * least, depth->rise_m) / point_m), -2.5, 1.0),
        log(held(echo->peak, 1.5, 20.0)),
        held(log(larger(1e-3, echo->mean) / larger(1e-3, echo->peak)), -2.0, 0.0),
        held((double)echo->cells * dr_m / (shape->beams * larger(dr_m, echo->range_extent_m)), 0.0, 1.0),
        log(held(shape->contrast, 1.0, 12.0)),
    };
    memcpy(filled, values, (size_t)smaller_i(room, sizeof values / sizeof *values) * sizeof *values);
}

#endif
