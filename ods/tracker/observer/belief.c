/* The moments of the hypotheses of a belief taken together: see belief.py. */

#include "ods/tracker/observer/horizontal.h"

/* The first fields of `Belief`. */
typedef struct {
    const double *weight, *position, *variance, *covariance_ne, *by_height, *shared;
    int64_t hypotheses, n;
} Belief;

/* Adds the variances, (3, n), and covariance, (n,), of hypothesis h about the mean of all, (3, n). */
static void add_spread(const Belief *belief, int64_t h, const double *mean, double *variance, double *covariance_ne)
{
    const int64_t n = belief->n;
    const double *weight = belief->weight + h * n, *position = belief->position + 3 * h * n;
    for (int axis = 0; axis < 3; axis++) {
        const double *own = belief->variance + (3 * h + axis) * n, *middle = mean + axis * n, *place = position + axis * n;
        double *restrict sum = variance + axis * n;
        for (int64_t i = 0; i < n; i++)
            sum[i] += weight[i] * (own[i] + square(place[i] - middle[i]));
    }
    const double *own = belief->covariance_ne + h * n;
    double *restrict sum = covariance_ne;
    for (int64_t i = 0; i < n; i++)
        sum[i] += weight[i] * (own[i] + (position[i] - mean[i]) * (position[n + i] - mean[n + i]));
}

/* Fills the first two moments of the mixture, and what it shares. */
KERNEL(moment_match, "f8[h,n] weight, f8[h,3,n] position, f8[h,3,n] variance, f8[h,n] covariance_ne, f8[h,2,n] by_height, "
                     "f8[h,3,n] shared, out f8[3,n] mean, out f8[3,n] spread, out f8[n] mixed, out f8[2,n] height, "
                     "out f8[3,n] all")
{
    const Belief belief = {
        ARRAY(const double, 0), ARRAY(const double, 1), ARRAY(const double, 2), ARRAY(const double, 3),
        ARRAY(const double, 4), ARRAY(const double, 5), SIZE(0, 0), SIZE(0, 1),
    };
    const int64_t hypotheses = belief.hypotheses, n = belief.n;
    double *mean = ARRAY(double, 6), *variance = ARRAY(double, 7), *covariance_ne = ARRAY(double, 8);
    for (int axis = 0; axis < 3; axis++) {
        mixture(belief.weight, belief.position + axis * n, 3 * n, hypotheses, n, mean + axis * n);
        mixture(belief.weight, belief.shared + axis * n, 3 * n, hypotheses, n, ARRAY(double, 10) + axis * n);
    }
    for (int axis = 0; axis < 2; axis++)
        mixture(belief.weight, belief.by_height + axis * n, 2 * n, hypotheses, n, ARRAY(double, 9) + axis * n);
    memset(variance, 0, (size_t)(3 * n) * sizeof *variance);
    memset(covariance_ne, 0, (size_t)n * sizeof *covariance_ne);
    for (int64_t h = 0; h < hypotheses; h++)
        add_spread(&belief, h, mean, variance, covariance_ne);
}
