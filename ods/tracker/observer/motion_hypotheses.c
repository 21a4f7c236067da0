/* What all observers filter alike, height and radius of objects and the odds that they rest, and what they tell of them
   together with north and east [SSIE eq. 2]: see motion_hypotheses.py. */

#include "ods/tracker/observer/kalman/axis_kalman.h"
#include "ods/tracker/observer/creep.h"

/* The rows of `CommonState`. */
typedef struct {
    double *rest_height, *rest_height_variance, *height, *height_variance;
    double *climb, *slope, *residual, *radius, *radius_variance, *odds;
    double *pose_north, *pose_east;
    double *rest_square, *rest_square_variance, *square, *square_variance;
} CommonState;

#define COMMON_STATE "f8[16,n] common"

static CommonState common_rows(double *table, int64_t n)
{
#define ROW(k) (table + (k) * n)
    return (CommonState){ROW(0), ROW(1), ROW(2),  ROW(3),  ROW(4),  ROW(5),  ROW(6),  ROW(7),
                         ROW(8), ROW(9), ROW(10), ROW(11), ROW(12), ROW(13), ROW(14), ROW(15)};
#undef ROW
}

/* Returns the probability of log-odds. */
static inline double probability(double odds)
{
    return 1.0 / (1.0 + exp(-odds));
}

/* Sets the last k objects: height, its variance, radius, its variance, and variance of the vehicle's position. */
KERNEL(common_start, "out " COMMON_STATE ", f8[k] height, f8[k] variance, f8[k] radius, f8[k] radius_variance, "
                     "f8[2] pose_variance, float odds, float climb_variance")
{
    const int64_t n = SIZE(0, 1), count = SIZE(1, 0);
    const CommonState s = common_rows(ARRAY(double, 0), n);
    const double *height = ARRAY(const double, 1), *variance = ARRAY(const double, 2);
    const double *radius = ARRAY(const double, 3), *radius_variance = ARRAY(const double, 4);
    const double *pose_variance = ARRAY(const double, 5);
    if (count > n)
        return;
    for (int64_t k = 0, i = n - count; k < count; k++, i++) {
        s.rest_height[i] = s.height[i] = height[k];
        s.rest_height_variance[i] = s.height_variance[i] = variance[k];
        s.rest_square_variance[i] = s.square_variance[i] = FOURTH_MOMENT * square(variance[k]);
        s.residual[i] = FLOAT(7);
        s.radius[i] = radius[k], s.radius_variance[i] = radius_variance[k], s.odds[i] = FLOAT(6);
        s.pose_north[i] = pose_variance[0], s.pose_east[i] = pose_variance[1];
    }
}

/* Carries all objects on over `dt` seconds; spectral densities of noise as in `MotionSettings`. */
KERNEL(common_predict, "out " COMMON_STATE ", float dt, float acceleration_noise, float static_noise, float radius_noise")
{
    const int64_t n = SIZE(0, 1);
    const CommonState s = common_rows(ARRAY(double, 0), n);
    const double dt = FLOAT(1), noise = FLOAT(2), at_rest = FLOAT(3) * dt, of_radius = FLOAT(4) * dt;
    if (dt == 0.0)
        return;
#pragma GCC ivdep
    for (int64_t i = 0; i < n; i++) {
        const AxisState sinking = {s.height[i], s.climb[i], s.height_variance[i], s.slope[i], s.residual[i]};
        const AxisState sunk = axis_carried_on(sinking, dt, noise);
        s.height[i] = sunk.position, s.height_variance[i] = sunk.variance;
        s.slope[i] = sunk.slope, s.residual[i] = sunk.residual;
        s.rest_height_variance[i] += at_rest;
        s.radius_variance[i] += of_radius;
    }
}

/* Fills (n,) with the probabilities of log-odds. */
KERNEL(all_static, "f8[n] odds, out f8[n] static")
{
    for (int64_t i = 0; i < SIZE(0, 0); i++)
        ARRAY(double, 1)[i] = probability(ARRAY(const double, 0)[i]);
}

/* ---------------------------------------------------------------- what is reported of the objects */

/* How an object at rest creeps, (n,) each. */
typedef struct {
    double *nn, *ee, *ne; /* what is to be added to its variances and covariance if it does, m^2: C + d d' for the distance
                             d of both estimates of its place and d's covariance C without the unseen */
    double *chance;       /* that it does, by its place alone; 0 for what is settled to rest */
} Creep;

/* Returns an object by one hypothesis, whose arrays begin there. */
static inline Estimated estimated(const double *position, const double *variance, const double *covariance_ne,
                                  const double *unseen, int64_t n, int64_t i)
{
    const double *by = unseen + i;
    const int64_t step = STATE * n;
    return (Estimated){
        position[i], position[n + i], variance[i], variance[n + i], covariance_ne[i],
        {{by[0], by[n]}, {by[step], by[step + n]}, {by[2 * step], by[2 * step + n]}, {by[3 * step], by[3 * step + n]}},
    };
}

/* Takes the hypotheses that move together: fills (5, n) position, variance and covariance, and (UNSEEN, STATE, n), of the
   states only the place. */
static void take_together(const HorizontalState *where, double *mean, double *by)
{
    const int64_t n = where->n, models = where->models;
    for (int axis = 0; axis < 2; axis++) {
        mixture(where->share, where->position + (2 + axis) * n, 2 * n, models, n, mean + axis * n);
        mixture(where->share, where->variance + (2 + axis) * n, 2 * n, models, n, mean + (2 + axis) * n);
        for (int64_t c = axis; c < UNSEEN * STATE; c += STATE)
            mixture(where->share, where->unseen + (UNSEEN * STATE + c) * n, UNSEEN * STATE * n, models, n, by + c * n);
    }
    mixture(where->share, where->covariance_ne + n, n, models, n, mean + 4 * n);
}

/* Returns how all objects creep. */
static Creep creep(const CommonState *s, const HorizontalState *where)
{
    const int64_t n = where->n;
    double *mean = SCRATCH(double, 5 * n), *by = SCRATCH(double, UNSEEN * STATE * n), *made = SCRATCH(double, 4 * n);
    const Creep creeps = {made, made + n, made + 2 * n, made + 3 * n};
    take_together(where, mean, by);
#pragma GCC ivdep
    for (int64_t i = 0; i < n; i++) {
        const Estimated rest = estimated(where->position, where->variance, where->covariance_ne, where->unseen, n, i);
        const Estimated moving = estimated(mean, mean + 2 * n, mean + 4 * n, by, n, i);
        const RestingHeight height = {s->rest_height[i] - s->height[i], s->rest_square[i], s->rest_height_variance[i],
                                      s->rest_square_variance[i]};
        const Away away = away_from(&rest, &moving, height);
        creeps.nn[i] = away.nn + away.north * away.north;
        creeps.ee[i] = away.ee + away.east * away.east;
        creeps.ne[i] = away.ne + away.north * away.east;
        creeps.chance[i] = away.square;
    }
    for (int64_t i = 0; i < n; i++)
        creeps.chance[i] = s->odds[i] == INFINITY ? 0.0 : probability(creeps.chance[i] - EVEN_SQUARE);
    return creeps;
}

/* What `Belief` begins with, of all hypotheses. */
typedef struct {
    double *weight, *position, *variance, *by_height, *shared;
} Reported;

/* Tells of all objects by hypothesis h, but for the weight. */
static void report(const CommonState *s, const HorizontalState *where, int64_t h, const Reported *reported)
{
    const int64_t n = where->n;
    const double *height = h == RESTING ? s->rest_height : s->height;
    const double *height_variance = h == RESTING ? s->rest_height_variance : s->height_variance;
    const double *height_square = h == RESTING ? s->rest_square : s->square;
    const double *square_variance = h == RESTING ? s->rest_square_variance : s->square_variance;
    double *unseen = where->unseen + h * UNSEEN * STATE * n, *shared = reported->shared + 3 * h * n;
    const size_t row = (size_t)n * sizeof(double);
    memcpy(reported->position + 3 * h * n, where->position + 2 * h * n, 2 * row);
    memcpy(reported->position + (3 * h + 2) * n, height, row);
    memcpy(reported->variance + 3 * h * n, where->variance + 2 * h * n, 2 * row);
    memcpy(reported->variance + (3 * h + 2) * n, height_variance, row);
    memcpy(reported->by_height + 2 * h * n, unseen + HEIGHT * STATE * n, 2 * row);
#pragma GCC ivdep
    for (int64_t i = 0; i < n; i++) {
        const double bend = square_variance[i] + square(height_square[i]);
        const Shared all = shared_by_all(column_of(unseen, n, i), NORTH, height_variance[i], bend, UNSEEN);
        shared[i] = all.nn + s->pose_north[i];
        shared[n + i] = all.ee + s->pose_east[i];
        shared[2 * n + i] = all.ne;
    }
}

/* Fills weight, position, variance, by_height and shared of `Belief`. */
static void report_all(const CommonState *s, const HorizontalState *where, const Reported *reported)
{
    const int64_t n = where->n;
    for (int64_t h = 0; h <= where->models; h++)
        report(s, where, h, reported);
    for (int64_t i = 0; i < n; i++)
        reported->weight[i] = probability(s->odds[i]);
    for (int64_t h = 1; h <= where->models; h++)
        for (int64_t i = 0; i < n; i++)
            reported->weight[h * n + i] = (1.0 - reported->weight[i]) * where->share[(h - 1) * n + i];
    const Creep creeps = creep(s, where);
    double *shared = reported->shared + 3 * RESTING * n;
    for (int64_t i = 0; i < n; i++) {
        if (reported->weight[i] == 1.0)
            continue;
        shared[i] += creeps.chance[i] * creeps.nn[i];
        shared[n + i] += creeps.chance[i] * creeps.ee[i];
        shared[2 * n + i] += creeps.chance[i] * creeps.ne[i];
    }
}

/* Adds the variances, (3, n), and covariance, (n,), of hypothesis h about the mean of all, (3, n). */
static void add_spread(const Reported *reported, const double *covariances_ne, int64_t n, int64_t h, const double *mean,
                       double *variance, double *covariance_ne)
{
    const double *weight = reported->weight + h * n, *position = reported->position + 3 * h * n;
    for (int axis = 0; axis < 3; axis++) {
        const double *own = reported->variance + (3 * h + axis) * n;
        const double *middle = mean + axis * n, *place = position + axis * n;
        double *restrict sum = variance + axis * n;
        for (int64_t i = 0; i < n; i++)
            sum[i] += weight[i] * (own[i] + square(place[i] - middle[i]));
    }
    const double *own = covariances_ne + h * n;
    double *restrict sum = covariance_ne;
    for (int64_t i = 0; i < n; i++)
        sum[i] += weight[i] * (own[i] + (position[i] - mean[i]) * (position[n + i] - mean[n + i]));
}

/* Fills weight, position, variance, by_height and shared of `Belief`, and the first five fields of `Estimate`. */
KERNEL(belief_and_moments, COMMON_STATE ", " HORIZONTAL_STATE
       ", out f8[hypotheses,n] weight, out f8[hypotheses,3,n] place, out f8[hypotheses,3,n] spread, "
       "out f8[hypotheses,2,n] by_height, out f8[hypotheses,3,n] shared, out f8[3,n] mean, out f8[3,n] mean_spread, "
       "out f8[n] mixed, out f8[2,n] height, out f8[3,n] all")
{
    const HorizontalState where = horizontal_from(arguments);
    const int64_t n = where.n, hypotheses = where.models + 1;
    const CommonState s = common_rows(ARRAY(double, 0), n);
    const Reported reported = {ARRAY(double, 6), ARRAY(double, 7), ARRAY(double, 8), ARRAY(double, 9), ARRAY(double, 10)};
    double *mean = ARRAY(double, 11), *variance = ARRAY(double, 12), *covariance_ne = ARRAY(double, 13);
    if (where.models < 0)
        return;
    report_all(&s, &where, &reported);
    for (int axis = 0; axis < 3; axis++) {
        mixture(reported.weight, reported.position + axis * n, 3 * n, hypotheses, n, mean + axis * n);
        mixture(reported.weight, reported.shared + axis * n, 3 * n, hypotheses, n, ARRAY(double, 15) + axis * n);
    }
    for (int axis = 0; axis < 2; axis++)
        mixture(reported.weight, reported.by_height + axis * n, 2 * n, hypotheses, n, ARRAY(double, 14) + axis * n);
    memset(variance, 0, (size_t)(3 * n) * sizeof *variance);
    memset(covariance_ne, 0, (size_t)n * sizeof *covariance_ne);
    for (int64_t h = 0; h < hypotheses; h++)
        add_spread(&reported, where.covariance_ne, n, h, mean, variance, covariance_ne);
}

/* Mean and variance, (2, n) north and east each, of the velocity. */
typedef struct {
    const double *mean, *variance;
} Moments;

/* Sets the mean and variance of the velocity of object i along the three axes if it moves, what pings share included. */
static void velocity_if_moving(const CommonState *s, const HorizontalState *where, Moments moving, int64_t i,
                               double mean[3], double variance[3])
{
    const int64_t n = where->n;
    const double bend = s->square_variance[i] + square(s->square[i]);
    for (int axis = 0; axis < 2; axis++) {
        mean[axis] = moving.mean[axis * n + i];
        variance[axis] = moving.variance[axis * n + i];
    }
    mean[2] = s->climb[i];
    variance[2] = velocity_variance(s->height_variance[i], s->slope[i], s->residual[i]);
    for (int64_t m = 0; m < where->models; m++) {
        const Column unseen = column_of(where->unseen + (1 + m) * UNSEEN * STATE * n, n, i);
        const Shared all = shared_by_all(unseen, VELOCITY, s->height_variance[i], bend, UNSEEN);
        variance[NORTH] += where->share[m * n + i] * all.nn;
        variance[EAST] += where->share[m * n + i] * all.ee;
    }
}

/* Returns the mean square of the velocity with which object i may creep if it rests, m^2/s^2: that of `steady`, the first
   kind of motion. What creeps is not taken to climb. */
static Two crept(const CommonState *s, const HorizontalState *where, Moments steady, int64_t i)
{
    const int64_t n = where->n;
    const double bend = s->square_variance[i] + square(s->square[i]);
    const Column unseen = column_of(where->unseen + UNSEEN * STATE * n, n, i);
    const Shared all = shared_by_all(unseen, VELOCITY, s->height_variance[i], bend, CLIMB);
    return (Two){square(steady.mean[i]) + steady.variance[i] + all.nn,
                 square(steady.mean[n + i]) + steady.variance[n + i] + all.ee};
}

/* Fills (2, 3, n) mean and variance of the mixture's velocities; the static hypothesis has velocity 0, but what echoes
   cannot distinguish from that yet is part of the variance, unless the object is settled to rest: as much as it may creep.
   mean, variance: of north and east if the object moves, at a given height, and those of the first kind of motion;
   by_place: it creeps as likely as its place says, else it is taken to. */
KERNEL(velocities, COMMON_STATE ", " HORIZONTAL_STATE ", f8[2,n] mean, f8[2,n] spread, f8[2,n] steady_mean, "
                   "f8[2,n] steady_variance, bool by_place, out f8[2,3,n] moments")
{
    const HorizontalState where = horizontal_from(arguments);
    const int64_t n = where.n;
    const CommonState s = common_rows(ARRAY(double, 0), n);
    const Moments moving = {ARRAY(const double, 6), ARRAY(const double, 7)};
    const Moments steady = {ARRAY(const double, 8), ARRAY(const double, 9)};
    double *mixed = ARRAY(double, 11), *spread = mixed + 3 * n, mean[3], variance[3];
    if (where.models < 1)
        return;
    const double *chance = BOOL(10) ? creep(&s, &where).chance : NULL;
    for (int64_t i = 0; i < n; i++) {
        const double rests = probability(s.odds[i]), moves = 1.0 - rests;
        velocity_if_moving(&s, &where, moving, i, mean, variance);
        for (int axis = 0; axis < 3; axis++) {
            mixed[axis * n + i] = moves * mean[axis];
            spread[axis * n + i] = moves * (variance[axis] + rests * square(mean[axis]));
        }
        if (s.odds[i] == INFINITY)
            continue;
        const Two square = crept(&s, &where, steady, i);
        const double share = rests * (chance == NULL ? 1.0 : chance[i]);
        spread[i] += share * square.north;
        spread[n + i] += share * square.east;
    }
}

/* ---------------------------------------------------------------- measurements */

/* Takes in that object k is inside the fan, `half` above or below its `middle`.
   Each ping repeats the same evidence, so that it must not count as new each time: a height inside the fan's interval
   stays, one outside moves to its edge, and the variance is at most that of an object anywhere in the interval, about
   that height. */
static void into_fan(const Heights *heights, int64_t k, double height, double variance, double middle, double half)
{
    const double now = smaller(larger(height, middle - half), middle + half);
    heights->height[k] = now;
    heights->variance[k] = smaller(variance + square(now - height), half * half / 3.0 + square(now - middle));
    heights->step[k] = now - height;
}

/* Fills the fields of `Heights`, (5, 2, k): at rest, and moving. */
KERNEL(in_fan, COMMON_STATE ", i8[k] rows, f8[k] middle, f8[k] half, out f8[5,2,k] heights")
{
    const int64_t n = SIZE(0, 1), count = SIZE(1, 0), *rows = ARRAY(const int64_t, 1);
    const CommonState s = common_rows(ARRAY(double, 0), n);
    const double *middle = ARRAY(const double, 2), *half = ARRAY(const double, 3);
    const Heights heights = height_rows(ARRAY(double, 4), count);
    if (!all_inside(rows, count, n))
        return;
    for (int64_t k = 0; k < count; k++) {
        const int64_t i = rows[k];
        into_fan(&heights, k, s.rest_height[i], s.rest_height_variance[i], middle[k], half[k]);
        into_fan(&heights, count + k, s.height[i], s.height_variance[i], middle[k], half[k]);
        heights.square[k] = s.rest_square[i], heights.square_variance[k] = s.rest_square_variance[i];
        heights.square[count + k] = s.square[i], heights.square_variance[count + k] = s.square_variance[i];
    }
}

/* Takes in what measurement k, one of a moving object at k + count, says of the height of object i. */
static void learn_height(const CommonState *s, int64_t i, const Heights *heights, const Learned *learned, int64_t k,
                         int64_t moving, double least_variance)
{
    s->rest_height[i] = heights->height[k] + learned->step[k];
    s->height[i] = heights->height[moving] + learned->step[moving];
    /* Ranges and bearings do not depend on the climb: it could be a part of the horizontal velocity just as well. Taken
       from what they say of the height, each would make the other grow. */
    s->climb[i] += s->slope[i] * heights->step[moving];
    s->rest_height_variance[i] = larger(learned->variance[k], least_variance);
    s->height_variance[i] = larger(learned->variance[moving], least_variance);
    s->rest_square[i] = possible_square_mean(learned->square[k], s->rest_height_variance[i]);
    s->rest_square_variance[i] = possible_square_variance(learned->square_variance[k], s->rest_height_variance[i]);
    s->square[i] = possible_square_mean(learned->square[moving], s->height_variance[i]);
    s->square_variance[i] = possible_square_variance(learned->square_variance[moving], s->height_variance[i]);
}

/* Starts the height of the static hypothesis anew from that of the moving one. */
static void rest_here(const CommonState *s, int64_t i)
{
    s->rest_height[i] = s->height[i], s->rest_height_variance[i] = s->height_variance[i];
    s->rest_square[i] = s->square[i], s->rest_square_variance[i] = s->square_variance[i];
}

/* Updates height, radius and log-odds of `rows`; fills `disproved` with those whose static hypothesis has to start anew
   and returns how many they are.
   Log-odds are kept between `least` and `most`: from the first on the static hypothesis is disproved. */
KERNEL_INT(common_update, "out " COMMON_STATE ", i8[k] rows, f8[k] radius, f8[k] radius_variance, f8[2] pose_variance, "
                          "f8[5,2,k] heights, f8[5,2,k] learned, f8[k] since_s, float change_rate, float least_variance, "
                          "float least, float most, out i8[k] disproved")
{
    const int64_t n = SIZE(0, 1), count = SIZE(1, 0), *rows = ARRAY(const int64_t, 1);
    const CommonState s = common_rows(ARRAY(double, 0), n);
    const double *radius = ARRAY(const double, 2), *radius_variance = ARRAY(const double, 3);
    const double *pose_variance = ARRAY(const double, 4), *since_s = ARRAY(const double, 7);
    const Heights heights = height_rows(ARRAY(double, 5), count);
    const Learned learned = learned_rows(ARRAY(double, 6), count);
    int64_t found = 0, *disproved = ARRAY(int64_t, 12);
    if (!all_inside(rows, count, n))
        return 0;
    for (int64_t k = 0; k < count; k++) {
        const int64_t i = rows[k], moving = count + k;
        double rests = probability(s.odds[i]);
        rests += FLOAT(8) * smaller(since_s[k], 1.0) * (1.0 - 2.0 * rests);
        const double odds = log(rests / (1.0 - rests)) + learned.log_likelihood[k] - learned.log_likelihood[moving];
        learn_height(&s, i, &heights, &learned, k, moving, FLOAT(9));
        s.pose_north[i] = pose_variance[0], s.pose_east[i] = pose_variance[1];
        const AxisState size = {s.radius[i], 0.0, s.radius_variance[i], 0.0, 0.0};
        const AxisState corrected = axis_corrected(size, radius[k], radius_variance[k]);
        s.radius[i] = corrected.position, s.radius_variance[i] = corrected.variance;
        if (odds < FLOAT(10)) {
            rest_here(&s, i);
            disproved[found++] = i;
        }
        s.odds[i] = smaller(larger(odds, FLOAT(10)), FLOAT(11));
    }
    return found;
}
