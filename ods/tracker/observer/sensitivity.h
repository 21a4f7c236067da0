/* What no number of pings averages away: the height that the fan does not resolve, and the bias of the pose.

   North and east follow from range and bearing only for a given height, and the bias of the attitude turns them about the
   vehicle. Both are the same at every ping. The filters of north and east are those for a given height, and beside them
   go the derivatives of what they estimate: by the height, by its square, by the attitude's standard deviation. A filter
   is linear in what is measured, so the derivative of its estimate is its answer to the derivative of the measurement: it
   is corrected with the same gain. Where the vehicle looks as before, both agree, and the height stays as unknown as it
   was; where it moved or turned they differ, and the innovation depends on the height: the separate-bias filter of B.
   Friedland, Treatment of bias in recursive filtering, IEEE Trans. Automatic Control 14(4), 1969, which gives what one
   large filter would. The attitude is only considered, not estimated (S. F. Schmidt, Application of state-space methods to
   navigation problems, Advances in Control Systems 3, 1966), as it is that of all objects. So is the climb of one that
   moves: ranges and bearings distinguish it neither from a horizontal velocity nor from an error of the height.

   Tables are (hypotheses, UNSEEN, STATE, n): derivatives of north, east and their velocities. Functions are of one object
   by one hypothesis, a column of (UNSEEN, STATE). */

#ifndef ODS_SENSITIVITY_H
#define ODS_SENSITIVITY_H

#include "ods/tracker/observer/horizontal.h"

/* Mean of the height's fourth power, from its middle, over the square of its variance: that of an even distribution; */
#define FOURTH_MOMENT 1.8
/* its largest square, over its variance. */
#define MOST_SQUARE 3.0
/* Of a coordinate's variance at least this share is independent of the other's: rounding must not make it negative. */
#define LEAST_SHARE 1e-14
/* By a tilt of so many standard deviations of its noise the vehicle may not have tilted at all. */
#define NOISE_SIGMAS 2.0

/* Derivative by what is unseen, `c`, of a row of the state. */
#define BY(unseen, c, row) AT(unseen, (c) * STATE + (row))

typedef struct {
    double north, east;
} Two;

/* North and east with their covariance. */
typedef struct {
    double north, east;
    double variance_north, variance_east, covariance_ne;
} Place;

/* What an echo's place in the fan says of the heights of the objects seen: (2, count), at rest and moving. */
typedef struct {
    double *height, *variance;
    double *square, *square_variance; /* what was learned of the height's square, about that mean: its mean and variance */
    double *step;                     /* by which the height changed */
} Heights;

/* Names the rows of a (5, 2, count) table. */
static inline Heights height_rows(double *table, int64_t count)
{
    const int64_t row = 2 * count;
    return (Heights){table, table + row, table + 2 * row, table + 3 * row, table + 4 * row};
}

/* One measurement, north and east at the mean height of a hypothesis. */
typedef struct {
    double north, east;
    double variance_north, variance_east, covariance_ne;
    double variance, square, square_variance; /* of the height, as in `Heights` */
    Two by_height, bend, by_attitude;         /* derivatives at the mean height */
    Two azimuth;                              /* as in `PositionMeasurement`, */
    double tilt_variance;                     /* too */
} Fix;

/* Of a filter: by how much its states follow an innovation. */
typedef struct {
    double north[STATE], east[STATE];
} Gain;

/* How a measurement differs from what a hypothesis expects, at its mean height. */
typedef struct {
    double north, east;
    double distance, determinant;     /* squared, over the covariance; of the covariance */
    double step, variance;            /* what it says of the height: change of the mean, and the variance then, */
    double square, square_variance;   /* and the same of the height's square */
} Innovation;

/* Returns the log of the density of a measurement, times 2 pi. */
static inline double log_likelihood(double distance, double determinant)
{
    return -0.5 * (distance + log(determinant));
}

/* Fills by how much the states change as the mean height does by `step`; the derivatives become those there. */
static inline void lowered(Column unseen, double step, double by[STATE])
{
    for (int row = 0; row < STATE; row++) {
        const double slope = BY(unseen, HEIGHT, row), bend = BY(unseen, BEND, row);
        BY(unseen, HEIGHT, row) = slope + 2.0 * bend * step;
        by[row] = (slope + bend * step) * step;
    }
}

/* Time update over `dt` seconds of the derivatives of n objects by one hypothesis: places change by the velocities.
   The height is the present one: an object that climbs by `climb`, a standard deviation, m/s, was lower by dt of that. */
static inline void carry_on(double *table, int64_t n, double dt, double climb)
{
    double *restrict by_climb = table + CLIMB * STATE * n;
    const double *restrict by_height = table + HEIGHT * STATE * n;
    for (int64_t k = 0; k < STATE * n; k++)
        by_climb[k] -= dt * climb * by_height[k];
    for (int c = 0; c < UNSEEN; c++) {
        double *restrict place = table + c * STATE * n;
        const double *restrict velocity = place + VELOCITY * n;
        for (int64_t k = 0; k < VELOCITY * n; k++)
            place[k] += dt * velocity[k];
    }
}

/* Returns measurement k of an object at rest or moving, g. */
static inline Fix fix_of(const PositionMeasurement *measured, int64_t k, const Heights *heights, int g)
{
    const int64_t count = measured->count, at = g * count + k;
    const double *slopes = measured->sensitivity + k;
#define SLOPE(c) ((Two){slopes[2 * (c) * count], slopes[(2 * (c) + 1) * count]})
    const Two by_height = SLOPE(HEIGHT), bend = SLOPE(BEND), by_attitude = SLOPE(ATTITUDE);
#undef SLOPE
    const double lower = heights->height[at] - measured->height[k];
    return (Fix){
        .north = measured->position[k] + (by_height.north + bend.north * lower) * lower,
        .east = measured->position[count + k] + (by_height.east + bend.east * lower) * lower,
        .variance_north = measured->variance_north[k],
        .variance_east = measured->variance_east[k],
        .covariance_ne = measured->covariance_ne[k],
        .variance = heights->variance[at],
        .square = heights->square[at],
        .square_variance = heights->square_variance[at],
        .by_height = {by_height.north + 2.0 * bend.north * lower, by_height.east + 2.0 * bend.east * lower},
        .bend = bend,
        .by_attitude = by_attitude,
        .azimuth = {measured->azimuth[k], measured->azimuth[count + k]},
        .tilt_variance = *measured->tilt_variance,
    };
}

/* Lets the derivatives by c follow those of the measurement. */
static inline void follow(Column unseen, int c, const Gain *gain, Two slope)
{
    const double north = slope.north - BY(unseen, c, NORTH), east = slope.east - BY(unseen, c, EAST);
    for (int row = 0; row < STATE; row++)
        BY(unseen, c, row) += gain->north[row] * north + gain->east[row] * east;
}

/* Turns what is unseen with the line of sight, which turns as the estimate moves across it. Of all measurements before,
   the derivatives there would be others, too: else each correction, which is mostly noise, would look like another look
   at the object, and depend on its height. */
static inline void turn(Column unseen, double angle)
{
    for (int c = 0; c < UNSEEN; c++) {
        const double north = BY(unseen, c, NORTH), east = BY(unseen, c, EAST);
        BY(unseen, c, NORTH) = north - angle * east;
        BY(unseen, c, EAST) = east + angle * north;
    }
}

/* Corrects the derivatives as the filter corrects its states. */
static inline void correct_unseen(Column unseen, const Gain *gain, const Innovation *residual, const Fix *fix)
{
    follow(unseen, HEIGHT, gain, fix->by_height);
    follow(unseen, BEND, gain, fix->bend);
    follow(unseen, ATTITUDE, gain, fix->by_attitude);
    follow(unseen, CLIMB, gain, (Two){0.0, 0.0});
    const double north = gain->north[NORTH] * residual->north + gain->east[NORTH] * residual->east;
    const double east = gain->north[EAST] * residual->north + gain->east[EAST] * residual->east;
    turn(unseen, north * fix->azimuth.north + east * fix->azimuth.east);
}

/* Returns the share that counts of what a measurement says of the height, so that it leaves `alike` of `variance`.
   A climb looks like an error of the height of the variance `alike`, the same at each ping: it does not average away.
   `information`: what the measurement would take off the variance, over its square. */
static inline double beyond(double variance, double information, double alike)
{
    const double taken = variance * smaller(variance * information, 1.0);
    return smaller(larger(variance - alike, 0.0) / larger(taken, NOT_ZERO), 1.0);
}

/* Returns the share that counts of what is learned of the height by looking from another direction, which changes the
   derivative by the root of `changed`: the noise of the tilt changes it, too, and is no evidence. */
static inline double more_than_noise(double changed, double tilt_variance)
{
    return larger(1.0 - square(NOISE_SIGMAS) * tilt_variance / larger(changed, NOT_ZERO), 0.0);
}

/* Returns a' S^-1 a times the determinant of S. */
static inline double squared(Two a, double s_nn, double s_ee, double s_ne)
{
    return s_ee * a.north * a.north - 2.0 * s_ne * a.north * a.east + s_nn * a.east * a.east;
}

/* Compares a measurement with a hypothesis, whose `place` is that at its mean height. */
static inline Innovation innovation(Column unseen, const Place *place, const Fix *fix)
{
    const double north = fix->north - place->north, east = fix->east - place->east;
    /* The place is the same by both: what is unseen moves the measurement less than the estimate by this. */
    const Two by = {BY(unseen, HEIGHT, NORTH) - fix->by_height.north, BY(unseen, HEIGHT, EAST) - fix->by_height.east};
    const Two bend = {BY(unseen, BEND, NORTH) - fix->bend.north, BY(unseen, BEND, EAST) - fix->bend.east};
    const Two turn = {BY(unseen, ATTITUDE, NORTH) - fix->by_attitude.north, BY(unseen, ATTITUDE, EAST) - fix->by_attitude.east};
    const Two climb = {BY(unseen, CLIMB, NORTH), BY(unseen, CLIMB, EAST)};
    const double spread = fix->variance, bent = fix->square_variance;
    const double s_nn = place->variance_north + fix->variance_north + square(by.north) * spread + square(bend.north) * bent
                        + square(turn.north) + square(climb.north);
    const double s_ee = place->variance_east + fix->variance_east + square(by.east) * spread + square(bend.east) * bent
                        + square(turn.east) + square(climb.east);
    const double s_ne = place->covariance_ne + fix->covariance_ne + by.north * by.east * spread
                        + bend.north * bend.east * bent + turn.north * turn.east + climb.north * climb.east;
    const double determinant = larger(s_nn * s_ee - s_ne * s_ne, LEAST_SHARE * s_nn * s_ee), inverse = 1.0 / determinant;
    const double new_north = north - bend.north * fix->square, new_east = east - bend.east * fix->square;
    const double whitened_north = (s_ee * new_north - s_ne * new_east) * inverse;
    const double whitened_east = (s_nn * new_east - s_ne * new_north) * inverse;
    const double information = squared(by, s_nn, s_ee, s_ne) * inverse;
    const double information_bend = squared(bend, s_nn, s_ee, s_ne) * inverse;
    const double climbed = square(climb.north) + square(climb.east), lower = square(by.north) + square(by.east);
    const double alike = climbed / larger(lower, NOT_ZERO);
    const double part = more_than_noise(lower, fix->tilt_variance) * beyond(spread, information, alike);
    return (Innovation){
        .north = north,
        .east = east,
        .distance = new_north * whitened_north + new_east * whitened_east,
        .determinant = determinant,
        .step = part * spread * (by.north * whitened_north + by.east * whitened_east),
        .variance = spread * (1.0 - part * smaller(spread * information, 1.0)),
        .square = fix->square + bent * (bend.north * whitened_north + bend.east * whitened_east),
        .square_variance = bent * larger(1.0 - bent * information_bend, 0.0),
    };
}

/* Returns the square of the height that the height's variance allows, */
static inline double possible_square_mean(double square, double height_variance)
{
    return smaller(larger(square, 0.0), MOST_SQUARE * height_variance);
}

/* and its variance. */
static inline double possible_square_variance(double variance, double height_variance)
{
    return smaller(variance, FOURTH_MOMENT * height_variance * height_variance);
}

/* What all pings share of two coordinates: both variances and their covariance. */
typedef struct {
    double nn, ee, ne;
} Shared;

/* Returns that of states `row` and `row` + 1. `height`, `bend`: mean squares of the height and of its square, m^2 and
   m^4; `kinds`: the first so many of what is unseen. */
static inline Shared shared_by_all(Column unseen, int row, double height, double bend, int kinds)
{
    Shared sum = {0.0, 0.0, 0.0};
    for (int c = 0; c < kinds; c++) {
        const double north = BY(unseen, c, row), east = BY(unseen, c, row + 1);
        const double spread = c == HEIGHT ? height : c == BEND ? bend : 1.0;
        sum.nn += spread * north * north;
        sum.ee += spread * east * east;
        sum.ne += spread * north * east;
    }
    return sum;
}

#endif
