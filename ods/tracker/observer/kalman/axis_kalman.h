/* The paper's Kalman filters in closed form: position and velocity along one axis, event driven [SSIE eq. 2].

   State of an axis: position and velocity; its covariance P = L D L' is kept in factors, L = [[1, 0], [slope, 1]] and
   D = diag(variance, residual):

       variance = var(position)
       slope    = cov(position, velocity) / var(position)
       residual = var(velocity) that would be left if the position were known

   In this form a measurement of position changes nothing but `variance` (slope and residual drop out of the update), and
   the time update is a sum of positive terms only: P stays symmetric and positive definite whatever the noise ratios and
   intervals. A filter without velocity (a radius, a coordinate at rest) is one whose velocity, slope and residual are 0.
   Factored filters: G. J. Bierman, Factorization Methods for Discrete Sequential Estimation, 1977. */

#ifndef ODS_AXIS_KALMAN_H
#define ODS_AXIS_KALMAN_H

#include "kernel.h"

typedef struct {
    double position, velocity;
    double variance, slope, residual;
} AxisState;

/* Time update over `dt` > 0 seconds. `noise`: spectral density of the acceleration, m^2/s^3.
   Process noise of white acceleration: Q = noise * [[dt^3/3, dt^2/2], [dt^2/2, dt]]; two steps equal one long one. */
static inline AxisState axis_carried_on(AxisState s, double dt, double noise)
{
    const double turn = s.slope * dt, dt_2 = dt * dt;
    const double variance = s.variance * square(1.0 + turn) + s.residual * dt_2 + (noise * dt_2 * dt / 3.0 + NOT_ZERO);
    const double covariance = s.variance * s.slope * (1.0 + turn) + s.residual * dt + noise * dt_2 / 2.0;
    /* det(A + Q) = det A + det Q + tr(adj(Q) A), the last written as a sum of squares. */
    const double mixed = s.variance * (square(1.0 + turn / 2.0) + turn * turn / 12.0) + s.residual * (dt_2 / 3.0);
    const double determinant = s.variance * s.residual + (noise * dt) * mixed + square(noise * dt_2) / 12.0;
    return (AxisState){s.position + s.velocity * dt, s.velocity, variance, covariance / variance, determinant / variance};
}

/* Measurement update of position with `noise_variance` > 0; slope and residual stay. */
static inline AxisState axis_corrected(AxisState s, double measured, double noise_variance)
{
    const double gain = s.variance / (s.variance + noise_variance), step = gain * (measured - s.position);
    return (AxisState){s.position + step, s.velocity + s.slope * step, gain * noise_variance, s.slope, s.residual};
}

/* Returns var(velocity) of the factored covariance. */
static inline double velocity_variance(double variance, double slope, double residual)
{
    return residual + slope * slope * variance;
}

#endif
