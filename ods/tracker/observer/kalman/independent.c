/* Independent Kalman filters for north and east, in closed form (axis_kalman.h) [SSIE eq. 2]: see independent.py. */

#include "ods/tracker/observer/kalman/axis_kalman.h"
#include "ods/tracker/observer/sensitivity.h"

/* Largest correlation of two errors that is kept. */
#define MOST_ALIKE (1.0 - 1e-9)

/* All that is known of n objects: the rows of `IndependentState`, (2, n) each, north and east, of `CrossCovariances`,
   (n,) each, and the derivatives, (2, UNSEEN, STATE, n). Place and variance are those by hypothesis RESTING, then by
   MOVING. */
typedef struct {
    double *place[2], *variance[2], *velocity, *slope, *residual;
    double *both[2], *north_velocity, *east_velocity, *velocities;
    double *unseen;
    int64_t n;
} Tables;

#define TABLES "out f8[7,2,n] filters, out f8[5,n] together, out f8[2,4,4,n] unseen"

static Tables tables_of(const Argument *arguments)
{
    const int64_t n = SIZE(0, 2);
    double *filters = ARRAY(double, 0), *together = ARRAY(double, 1);
#define AXES(k) (filters + 2 * (k) * n)
#define ROW(k) (together + (k) * n)
    return (Tables){{AXES(0), AXES(1)}, {AXES(2), AXES(3)}, AXES(4), AXES(5), AXES(6), {ROW(0), ROW(1)}, ROW(2), ROW(3), ROW(4),
                    ARRAY(double, 2), n};
#undef AXES
#undef ROW
}

/* Returns a covariance that rounding did not make larger than the variances allow. */
static inline double possible(double covariance, double north, double east)
{
    const double most = MOST_ALIKE * sqrt(north * east);
    return smaller(larger(covariance, -most), most);
}

/* Returns an axis of an object if it moves, `at` = axis * n + i, */
static inline AxisState moving_axis(const Tables *t, int64_t at)
{
    return (AxisState){t->place[MOVING][at], t->velocity[at], t->variance[MOVING][at], t->slope[at], t->residual[at]};
}

/* and if it rests. */
static inline AxisState resting_axis(const Tables *t, int64_t at)
{
    return (AxisState){t->place[RESTING][at], 0.0, t->variance[RESTING][at], 0.0, 0.0};
}

/* Carries all filters on over `dt` seconds; noise of the acceleration, noise at rest, standard deviation of a climb. */
KERNEL(independent_predict, TABLES ", float dt, float acceleration_noise, float static_noise, float climb")
{
    const Tables t = tables_of(arguments);
    const int64_t n = t.n;
    const double dt = FLOAT(3), noise = FLOAT(4), at_rest = FLOAT(5) * dt;
    if (dt == 0.0)
        return;
#pragma GCC ivdep
    for (int64_t at = 0; at < 2 * n; at++) {
        const AxisState moved = axis_carried_on(moving_axis(&t, at), dt, noise);
        t.place[MOVING][at] = moved.position, t.variance[MOVING][at] = moved.variance;
        t.slope[at] = moved.slope, t.residual[at] = moved.residual;
        t.variance[RESTING][at] += at_rest;
    }
#pragma GCC ivdep
    for (int64_t i = 0; i < n; i++) {
        const double moved = t.both[MOVING][i] + dt * (t.north_velocity[i] + t.east_velocity[i] + dt * t.velocities[i]);
        t.north_velocity[i] += dt * t.velocities[i];
        t.east_velocity[i] += dt * t.velocities[i];
        t.both[MOVING][i] = possible(moved, t.variance[MOVING][i], t.variance[MOVING][n + i]);
    }
    carry_on(t.unseen + UNSEEN * STATE * n, n, dt, FLOAT(6));
}

/* Changes the states of hypothesis h of object i as its mean height does by `step`. */
static void lower(const Tables *t, int h, int64_t i, double step)
{
    double by[STATE];
    lowered(column_of(t->unseen + h * UNSEEN * STATE * t->n, t->n, i), step, by);
    for (int axis = 0; axis < 2; axis++) {
        t->place[h][axis * t->n + i] += by[axis];
        if (h == MOVING)
            t->velocity[axis * t->n + i] += by[VELOCITY + axis];
    }
}

/* By how much position and velocity of an axis follow the innovation. */
typedef struct {
    double place, velocity;
} AxisGain;

/* Corrects one axis of hypothesis h. */
static AxisGain correct_axis(const Tables *t, int h, int64_t at, double step, double noise)
{
    const AxisState before = h == RESTING ? resting_axis(t, at) : moving_axis(t, at);
    const AxisState after = axis_corrected(before, before.position + step, noise);
    t->place[h][at] = after.position, t->variance[h][at] = after.variance;
    if (h == MOVING)
        t->velocity[at] = after.velocity;
    return (AxisGain){after.variance / noise, after.slope * (after.variance / noise)};
}

/* Corrects the covariances of north and east of a hypothesis whose filters were corrected; `noise`: that of the
   measurement. */
static void correct_together(const Tables *t, int h, int64_t i, const Gain *gain, double noise)
{
    const double north = gain->north[NORTH], east = gain->east[EAST];
    const double v_north = gain->north[VELOCITY], v_east = gain->east[VELOCITY + 1];
    const double before = t->both[h][i];
    const double left = (1.0 - north) * (1.0 - east) * before + north * east * noise;
    t->both[h][i] = possible(left, t->variance[h][i], t->variance[h][t->n + i]);
    if (h == RESTING)
        return;
    double *of_north = &t->north_velocity[i], *of_east = &t->east_velocity[i];
    t->velocities[i] += v_north * v_east * (before + noise) - v_north * *of_east - v_east * *of_north;
    *of_north = (1.0 - east) * (*of_north - v_north * before) + v_north * east * noise;
    *of_east = (1.0 - north) * (*of_east - v_east * before) + north * v_east * noise;
}

/* Corrects hypothesis h of object i by a measurement; returns what that is to it. */
static Innovation correct(const Tables *t, int h, int64_t i, const Fix *fix)
{
    const int64_t n = t->n;
    const Column unseen = column_of(t->unseen + h * UNSEEN * STATE * n, n, i);
    const Place place = {t->place[h][i], t->place[h][n + i], t->variance[h][i], t->variance[h][n + i], t->both[h][i]};
    const Innovation residual = innovation(unseen, &place, fix);
    const AxisGain north = correct_axis(t, h, i, residual.north, fix->variance_north);
    const AxisGain east = correct_axis(t, h, n + i, residual.east, fix->variance_east);
    const Gain gain = {{north.place, 0.0, north.velocity, 0.0}, {0.0, east.place, 0.0, east.velocity}};
    correct_together(t, h, i, &gain, fix->covariance_ne);
    correct_unseen(unseen, &gain, &residual, fix);
    return residual;
}

/* Updates all filters of `rows`, in place, and fills the (5, 2, k) table of `Learned`. */
KERNEL(independent_update, TABLES ", i8[k] rows, " POSITION_MEASUREMENT ", f8[5,2,k] heights, out f8[5,2,k] learned")
{
    const Tables t = tables_of(arguments);
    const int64_t count = SIZE(3, 0), *rows = ARRAY(const int64_t, 3);
    const PositionMeasurement measured = position_measurement_from(arguments, 4);
    const Heights heights = height_rows(ARRAY(double, 16), count);
    const Learned learned = learned_rows(ARRAY(double, 17), count);
    if (!all_inside(rows, count, t.n))
        return;
    for (int64_t k = 0; k < count; k++)
        for (int h = RESTING; h <= MOVING; h++) {
            const int64_t at = h * count + k;
            lower(&t, h, rows[k], heights.step[at]);
            const Fix fix = fix_of(&measured, k, &heights, h);
            const Innovation residual = correct(&t, h, rows[k], &fix);
            learned.log_likelihood[at] = log_likelihood(residual.distance, residual.determinant);
            learned.step[at] = residual.step, learned.variance[at] = residual.variance;
            learned.square[at] = residual.square, learned.square_variance[at] = residual.square_variance;
            lower(&t, h, rows[k], residual.step);
        }
}

/* Lets the static hypotheses of `heirs` learn where those of `old`, the same objects, were. */
KERNEL(independent_join, TABLES ", i8[k] heirs, i8[k] old")
{
    const Tables t = tables_of(arguments);
    const int64_t count = SIZE(3, 0), *heirs = ARRAY(const int64_t, 3), *old = ARRAY(const int64_t, 4), n = t.n;
    if (!all_inside(heirs, count, n) || !all_inside(old, count, n))
        return;
    for (int64_t k = 0; k < count; k++) {
        const int64_t heir = heirs[k], before = old[k];
        double left = t.both[RESTING][heir], added = t.both[RESTING][before];
        for (int axis = 0; axis < 2; axis++) {
            const double noise = t.variance[RESTING][axis * n + before];
            const double step = t.place[RESTING][axis * n + before] - t.place[RESTING][axis * n + heir];
            const double gain = correct_axis(&t, RESTING, axis * n + heir, step, noise).place;
            left *= 1.0 - gain, added *= gain;
            for (int c = 0; c < UNSEEN; c++) {
                double *own = t.unseen + (c * STATE + axis) * n;
                own[heir] += gain * (own[before] - own[heir]);
            }
        }
        t.both[RESTING][heir] = possible(left + added, t.variance[RESTING][heir], t.variance[RESTING][n + heir]);
    }
}
