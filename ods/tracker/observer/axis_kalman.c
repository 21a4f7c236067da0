/* The filter of one axis for whoever has a few of them, such as tests: see axis_kalman.h. */

#include "ods/tracker/observer/axis_kalman.h"

static AxisState axis_of(const double *states, int64_t n, int64_t i)
{
    return (AxisState){states[i], states[n + i], states[2 * n + i], states[3 * n + i], states[4 * n + i]};
}

static void set_axis(double *states, int64_t n, int64_t i, AxisState s)
{
    states[i] = s.position, states[n + i] = s.velocity;
    states[2 * n + i] = s.variance, states[3 * n + i] = s.slope, states[4 * n + i] = s.residual;
}

KERNEL(axis_predict, "out f8[5,n] states, float dt, float noise")
{
    double *states = ARRAY(double, 0);
    const int64_t n = SIZE(0, 1);
    if (FLOAT(1) == 0.0)
        return;
    for (int64_t i = 0; i < n; i++)
        set_axis(states, n, i, axis_carried_on(axis_of(states, n, i), FLOAT(1), FLOAT(2)));
}

KERNEL(axis_update, "out f8[5,n] states, f8[n] measured, f8[n] noise_variance")
{
    double *states = ARRAY(double, 0);
    const double *measured = ARRAY(const double, 1), *noise_variance = ARRAY(const double, 2);
    const int64_t n = SIZE(0, 1);
    for (int64_t i = 0; i < n; i++)
        set_axis(states, n, i, axis_corrected(axis_of(states, n, i), measured[i], noise_variance[i]));
}
