/* Kalman filters for north and east together, their covariances kept in factors, event driven.

   A state is north, east and their velocities; its covariance P = L D L', L unit lower triangular, D diagonal and never
   negative. Positions come first, so that what is known of them alone is the upper left corner of the factors. Every
   change is a sum of squares with weights that are not negative: P stays symmetric and positive definite whatever the
   noise ratios and intervals. Measurement update: Bierman's; all else: C. L. Thornton's weighted Gram-Schmidt
   orthogonalization (G. J. Bierman, Factorization Methods for Discrete Sequential Estimation, 1977).

   All functions are of one object, a column of a (FACTORS, n) table, in place. */

#ifndef ODS_UD_FILTER_H
#define ODS_UD_FILTER_H

#include "ods/tracker/observer/sensitivity.h"

/* After the state the rows of D, then those of L below its diagonal: (1, 0), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2). */
enum { DIAGONAL = STATE, L10 = 2 * STATE, L20, L21, L30, L31, L32, FACTORS };

/* Sets state and covariance; the velocity is 0, as uncertain as is said, and not correlated with the position. */
static inline void ud_start(Column s, Place place, double velocity_variance)
{
    const double north = place.variance_north, east = place.variance_east, mixed = place.covariance_ne;
    for (int row = 0; row < FACTORS; row++)
        AT(s, row) = 0.0;
    AT(s, NORTH) = place.north, AT(s, EAST) = place.east;
    AT(s, L10) = mixed / north;
    AT(s, DIAGONAL + NORTH) = north;
    AT(s, DIAGONAL + EAST) = larger(east - mixed * mixed / north, LEAST_SHARE * east);
    AT(s, DIAGONAL + VELOCITY) = AT(s, DIAGONAL + VELOCITY + 1) = velocity_variance;
}

/* Returns the position with its covariance. */
static inline Place place_of(Column s)
{
    const double north = AT(s, DIAGONAL + NORTH), slope = AT(s, L10);
    return (Place){AT(s, NORTH), AT(s, EAST), north, AT(s, DIAGONAL + EAST) + slope * slope * north, slope * north};
}

/* Returns the variances of both velocities. */
static inline Two velocity_variances(Column s)
{
    const double north = AT(s, DIAGONAL + NORTH), east = AT(s, DIAGONAL + EAST), v_north = AT(s, DIAGONAL + VELOCITY);
    const double of_north = v_north + square(AT(s, L20)) * north + square(AT(s, L21)) * east;
    const double others = square(AT(s, L30)) * north + square(AT(s, L31)) * east + square(AT(s, L32)) * v_north;
    return (Two){of_north, AT(s, DIAGONAL + VELOCITY + 1) + others};
}

/* Makes both of two coordinates uncertain by `variance` >= 0 more: D of the first, L, D of the second. */
static inline void enlarge(double *first, double *slope, double *second, double variance)
{
    const double both = *first + variance, kept = both > 0.0 ? *first / both : 1.0;
    *first = both;
    *second += variance * (1.0 + *slope * *slope * kept);
    *slope *= kept;
}

/* Time update of what has no velocity: both coordinates become uncertain by `variance` >= 0. */
static inline void ud_drift(Column s, double variance)
{
    enlarge(&AT(s, DIAGONAL + NORTH), &AT(s, L10), &AT(s, DIAGONAL + EAST), variance);
}

/* Of a covariance that is the sum of weight[c] column[:, c] column[:, c]', six columns: a row, or the weights. */
typedef struct {
    double of[6];
} Six;

static inline double product(const Six *weight, const Six *a, const Six *b)
{
    double sum = 0.0;
    for (int c = 0; c < 6; c++)
        sum += weight->of[c] * a->of[c] * b->of[c];
    return sum;
}

/* Returns one by a square; 0 for 0, as nothing leans on what is certain. */
static inline double one_by(double square)
{
    return square > 0.0 ? 1.0 / square : 0.0;
}

/* Takes `other`, of which `inverse` is one by its own product, out of a row; returns how much of it was there. */
static inline double take_out(Six *row, const Six *other, const Six *weight, double inverse)
{
    const double share = product(weight, row, other) * inverse;
    for (int c = 0; c < 6; c++)
        row->of[c] -= share * other->of[c];
    return share;
}

/* Time update over `dt` > 0 seconds with white acceleration of spectral density `noise`, m^2/s^3, along each axis.
   Two steps equal one long one. Along an axis the noise is [[dt^3/3, dt^2/2], [dt^2/2, dt]]: a quarter of dt that the
   velocity gets before the step, and three quarters after it, along (dt/3, 1). */
static inline void ud_predict(Column s, double dt, double noise)
{
    AT(s, NORTH) += dt * AT(s, VELOCITY);
    AT(s, EAST) += dt * AT(s, VELOCITY + 1);
    const double l10 = AT(s, L10), l20 = AT(s, L20), l21 = AT(s, L21), l30 = AT(s, L30), l31 = AT(s, L31);
    double d2 = AT(s, DIAGONAL + VELOCITY), l32 = AT(s, L32), d3 = AT(s, DIAGONAL + VELOCITY + 1);
    enlarge(&d2, &l32, &d3, 0.25 * noise * dt);
    const double third = dt / 3.0, later = 0.75 * noise * dt;
    /* Rows of L, moved, then of the noise. */
    const Six weight = {{AT(s, DIAGONAL + NORTH), AT(s, DIAGONAL + EAST), d2, d3, later, later}};
    const Six north = {{1.0 + dt * l20, dt * l21, dt, 0.0, third, 0.0}};
    Six east = {{l10 + dt * l30, 1.0 + dt * l31, dt * l32, dt, 0.0, third}};
    Six v_north = {{l20, l21, 1.0, 0.0, 1.0, 0.0}};
    Six v_east = {{l30, l31, l32, 1.0, 0.0, 1.0}};
    double square = AT(s, DIAGONAL) = product(&weight, &north, &north), inverse = one_by(square);
    AT(s, L10) = take_out(&east, &north, &weight, inverse);
    AT(s, L20) = take_out(&v_north, &north, &weight, inverse);
    AT(s, L30) = take_out(&v_east, &north, &weight, inverse);
    square = AT(s, DIAGONAL + 1) = product(&weight, &east, &east), inverse = one_by(square);
    AT(s, L21) = take_out(&v_north, &east, &weight, inverse);
    AT(s, L31) = take_out(&v_east, &east, &weight, inverse);
    square = AT(s, DIAGONAL + 2) = product(&weight, &v_north, &v_north);
    AT(s, L32) = take_out(&v_east, &v_north, &weight, one_by(square));
    AT(s, DIAGONAL + 3) = product(&weight, &v_east, &v_east);
}

/* What a measurement of the position changes of the factors: D of the position, and the first column of L. */
typedef struct {
    double north, east;
    double of_east, of_v_north, of_v_east;
} Corner;

/* Takes one number in, that is h' x with variance `noise`; returns by how much the states follow it.
   f: L' h, which has no other entries; by_east: L of the velocities by east, which stays. */
static inline void take_in(Corner *corner, Two by_east, Two f, double noise, double *restrict gain)
{
    const double v0 = corner->north * f.north, v1 = corner->east * f.east;
    const double without = noise + f.east * v1, whole = without + f.north * v0, share = f.north / without;
    const double a = v1 * by_east.north, b = v1 * by_east.east, one_by_whole = 1.0 / whole;
    gain[NORTH] = v0 * one_by_whole;
    gain[EAST] = (v1 + v0 * corner->of_east) * one_by_whole;
    gain[VELOCITY] = (a + v0 * corner->of_v_north) * one_by_whole;
    gain[VELOCITY + 1] = (b + v0 * corner->of_v_east) * one_by_whole;
    *corner = (Corner){
        corner->north * (without * one_by_whole), corner->east * (noise / without),
        corner->of_east - share * v1, corner->of_v_north - share * a, corner->of_v_east - share * b,
    };
}

/* Measurement update with the north and east of a place less those of the state, whose noise is not 0 in any direction;
   returns how the states followed. */
static inline Gain ud_update(Column s, double away_north, double away_east, double north, double east, double mixed)
{
    const double slope = mixed / north, left = larger(east - slope * mixed, LEAST_SHARE * east);
    Corner corner = {AT(s, DIAGONAL), AT(s, DIAGONAL + EAST), AT(s, L10), AT(s, L20), AT(s, L30)};
    const Two by_east = {AT(s, L21), AT(s, L31)};
    Gain gain;
    take_in(&corner, by_east, (Two){1.0, 0.0}, north, gain.north);
    /* Of east only that part is new which north does not say already: its noise is independent. */
    take_in(&corner, by_east, (Two){corner.of_east - slope, 1.0}, left, gain.east);
    AT(s, DIAGONAL) = corner.north, AT(s, DIAGONAL + EAST) = corner.east;
    AT(s, L10) = corner.of_east, AT(s, L20) = corner.of_v_north, AT(s, L30) = corner.of_v_east;
    const double again = gain.north[EAST] + slope * (1.0 - gain.north[NORTH]);
    for (int row = 0; row < STATE; row++) {
        gain.north[row] -= again * gain.east[row];
        AT(s, row) += gain.north[row] * away_north + gain.east[row] * away_east;
    }
    return gain;
}

#endif
