/* Predictions and measurements as kernels take them, and what the place of an object depends on (model.py). */

#ifndef ODS_MODEL_H
#define ODS_MODEL_H

#include "ods/tracker/measurement/scan.h"

/* Distances, m, by which numbers are divided are no smaller, so that a direction exists. */
#define NEAREST_M 1e-3
/* Standard deviation of where what gives an echo of an object lies, in radii from its middle. */
#define PARTS 0.5

/* The rows of `PredictedMeasurement`'s table, which may have more axes than two: all its further axes are one here. */
typedef struct {
    double *range_m, *bearing, *elevation, *horizontal;
    double *along, *across, *mixed, *vertical;
} PredictedMeasurement;

/* Names the rows of a table of 8 rows of `count` numbers: `f8[8,n]` or `f8[8,h,n]` in signatures. */
static inline PredictedMeasurement predicted_rows(double *table, int64_t count)
{
#define ROW(k) (table + (k) * count)
    return (PredictedMeasurement){ROW(0), ROW(1), ROW(2), ROW(3), ROW(4), ROW(5), ROW(6), ROW(7)};
#undef ROW
}

/* What the ping does not see, but the horizontal place depends on: the height, its square, the bias of the attitude, and
   what earlier pings were related by, how much the height changes. */
enum { HEIGHT, BEND, ATTITUDE, CLIMB, UNSEEN };

/* Echoes converted to positions in the global frame, with their noise (see model.py). */
typedef struct {
    const double *position;                                         /* (3, k) */
    const double *variance_north, *variance_east, *covariance_ne;   /* (k,) each, as are the next four */
    const double *half_height, *radius, *radius_variance, *height;
    const double *azimuth;                                          /* (2, k) */
    const double *sensitivity;                                      /* (UNSEEN, 2, k) */
    const double *pose_variance, *tilt_variance;                    /* (2,), (1,) */
    int64_t count;                                                  /* k */
} PositionMeasurement;

/* A `PositionMeasurement` in a signature: twelve arguments. */
#define POSITION_MEASUREMENT                                                                                            \
    "f8[3,k] position, f8[k] variance_north, f8[k] variance_east, f8[k] covariance_ne, f8[k] half_height, f8[k] radius, "\
    "f8[k] radius_variance, f8[k] height, f8[2,k] azimuth, f8[4,2,k] sensitivity, f8[2] pose_variance, " \
    "f8[1] tilt_variance"

/* Returns the measurement of the twelve arguments from number k on. */
static inline PositionMeasurement position_measurement_from(const Argument *arguments, int k)
{
#define NUMBERS(i) ARRAY(const double, k + (i))
    return (PositionMeasurement){NUMBERS(0), NUMBERS(1), NUMBERS(2), NUMBERS(3), NUMBERS(4),  NUMBERS(5),
                                 NUMBERS(6), NUMBERS(7), NUMBERS(8), NUMBERS(9), NUMBERS(10), NUMBERS(11), SIZE(k, 1)};
#undef NUMBERS
}

/* Returns the angle wrapped to [-pi, pi). */
static inline double wrapped(double angle)
{
    if (-PI <= angle && angle < PI)
        return angle;
    const double turned = fmod(angle + PI, 2.0 * PI);
    return (turned < 0.0 ? turned + 2.0 * PI : turned) - PI;
}

#endif
