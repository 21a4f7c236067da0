/* What an object at rest may have crept unseen: the velocities that echoes do not distinguish from zero yet.

   An object that moves slowly across the line of sight seems to rest for long, and the average of its echoes lags behind
   it by more than that average's own standard deviation. How likely it rests is found against velocities of
   `velocity_sigma`, among which so slow ones are few: whoever meets one is misled. So whether it creeps is judged once
   more, for the covariance alone and whatever its speed, by how far the two estimates of its place are apart. If it rests,
   the average is the best estimate there is, and the covariance of the difference is the difference of the covariances
   (J. A. Hausman, Specification tests in econometrics, Econometrica 46, 1978). Both are compared at the same height, as
   each hypothesis has learned its own, and what the unseen does to one more than to the other is part of it. */

#ifndef ODS_CREEP_H
#define ODS_CREEP_H

#include "ods/tracker/observer/sensitivity.h"

/* Squared distance of both estimates over its covariance, 2 on average at rest, at which it creeps as likely as not. */
#define EVEN_SQUARE 4.0
/* Of the variance at rest: where that of one that moves is larger by less, both began at one place just now. */
#define LEAST_MORE 1e-9

/* The estimate of an object that moves, seen from that of one at rest. */
typedef struct {
    double north, east;
    double nn, ee, ne; /* by how much its variance north, east, and the covariance are larger, m^2 */
    double square;     /* of the distance, over its covariance; -infinity where nothing can be known */
} Away;

/* Height and its square, on which places depend, of an object at rest. */
typedef struct {
    double lower;                     /* by how much the height is more than what the hypotheses that move are reported for, */
    double square;                    /* and its square than what that at rest is reported for */
    double variance, square_variance; /* of both */
} RestingHeight;

/* One object by one hypothesis, or by several taken together. */
typedef struct {
    double north, east;
    double nn, ee, ne;
    Two by[UNSEEN]; /* derivatives of north and east */
} Estimated;

/* Compares both estimates of an object. */
static inline Away away_from(const Estimated *rest, const Estimated *moving, RestingHeight height)
{
    const double lower[UNSEEN] = {height.lower, height.lower * height.lower, 0.0, 0.0};
    const double mean[UNSEEN] = {0.0, height.square, 0.0, 0.0};
    const double variance[UNSEEN] = {height.variance, height.square_variance, 1.0, 1.0};
    double north = moving->north - rest->north, east = moving->east - rest->east;
    const double nn = moving->nn - rest->nn, ee = moving->ee - rest->ee, ne = moving->ne - rest->ne;
    double all_nn = nn, all_ee = ee, all_ne = ne;
    for (int c = 0; c < UNSEEN; c++) {
        const Two more = {moving->by[c].north - rest->by[c].north, moving->by[c].east - rest->by[c].east};
        north += moving->by[c].north * lower[c] + more.north * mean[c];
        east += moving->by[c].east * lower[c] + more.east * mean[c];
        all_nn += more.north * more.north * variance[c];
        all_ee += more.east * more.east * variance[c];
        all_ne += more.north * more.east * variance[c];
    }
    const double determinant = all_nn * all_ee - all_ne * all_ne;
    const bool unknown = nn <= LEAST_MORE * rest->nn || ee <= LEAST_MORE * rest->ee || determinant <= 0.0;
    const double square = squared((Two){north, east}, all_nn, all_ee, all_ne) / determinant;
    return (Away){north, east, nn, ee, ne, unknown ? -INFINITY : square};
}

#endif
