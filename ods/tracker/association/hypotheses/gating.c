/* Which echoes may be whose, and how well each pair inside the statistical gate explains the image (gating.py). */

#include "ods/tracker/association/hypotheses/gating.h"
#include "ods/tracker/measurement/coverage/cut_off.h"
#include "ods/tracker/measurement/coverage/normal.h"
#include "ods/tracker/measurement/model.h"

/* Of an echo that is cut off it is as likely as not that it shows the same part of its object as before: this share of
   its variance is then the error of the object's place, and does not count twice. */
#define KEPT 0.9
/* Least determinant over the product of the variances. */
#define CORRELATED 1e-3

/* n objects by h hypotheses of motion. */
typedef struct {
    PredictedMeasurement predicted; /* (h, n) each */
    const double *weight;           /* (h, n) */
    const double *radius, *radius_variance;
    int64_t hypotheses, n;
} Objects;

/* m echoes, and false alarms at each of them. */
typedef struct {
    EchoRows rows;
    const double *per_m2, *of_radius;
    int64_t m;
    int64_t *order;                    /* (m,) of the echoes by range, */
    double *range_m, *bearing;         /* and (m,) in this order */
    double sigma_range, sigma_bearing; /* the largest of all */
} Echoes;

typedef struct {
    double sigmas, detection_probability;
} Gate;

/* A squared distance, in standard deviations, and the determinant, m^4, of its covariance. */
typedef struct {
    double square, determinant;
} Distance;

/* Returns the distance of echo j from a hypothesis, k, of an object; `most`: largest variance, m^2, that the echo's
   place can have; `kept`: share of its variance that is the same error as the object's own. */
static Distance distance_of(const PredictedMeasurement *predicted, int64_t k, const EchoRows *echoes, int64_t j,
                            double most, double kept)
{
    const double horizontal = predicted->horizontal[k], s_mixed = (1.0 - kept) * predicted->mixed[k];
    const double along = echoes->range_m[j] - predicted->range_m[k];
    const double across = wrapped(echoes->bearing[j] - predicted->bearing[k]) * horizontal;
    const double own_along = smaller(most, square(echoes->sigma_range[j]));
    const double own_across = smaller(most, square(horizontal * echoes->sigma_bearing[j]));
    const double s_along = predicted->along[k] + own_along - 2.0 * kept * smaller(own_along, predicted->along[k]);
    const double s_across = predicted->across[k] + own_across - 2.0 * kept * smaller(own_across, predicted->across[k]);
    const double determinant = larger(s_along * s_across - square(s_mixed), CORRELATED * s_along * s_across);
    const double sum = s_across * square(along) - 2.0 * s_mixed * along * across + s_along * square(across);
    return (Distance){sum / determinant, determinant};
}

static double likelihood_of(Distance distance)
{
    return exp(-0.5 * distance.square) / sqrt(distance.determinant);
}

/* Compares two pointers to ranges, for qsort; equal ones stay in the order in which they are in memory. */
static int is_farther(const void *a, const void *b)
{
    const double *one = *(double *const *)a, *other = *(double *const *)b;
    return *one > *other || (*one == *other && one > other) ? 1 : -1;
}

/* Puts the echoes in order and finds their largest sigmas. */
static void put_in_order(Echoes *echoes)
{
    double **ranges = SCRATCH(double *, echoes->m);
    for (int64_t j = 0; j < echoes->m; j++)
        ranges[j] = echoes->rows.range_m + j;
    qsort(ranges, (size_t)echoes->m, sizeof *ranges, is_farther);
    echoes->order = SCRATCH(int64_t, echoes->m);
    for (int64_t place = 0; place < echoes->m; place++)
        echoes->order[place] = ranges[place] - echoes->rows.range_m;
    echoes->range_m = SCRATCH(double, echoes->m), echoes->bearing = SCRATCH(double, echoes->m);
    echoes->sigma_range = echoes->sigma_bearing = 0.0;
    for (int64_t place = 0; place < echoes->m; place++) {
        const int64_t j = echoes->order[place];
        echoes->range_m[place] = echoes->rows.range_m[j], echoes->bearing[place] = echoes->rows.bearing[j];
        echoes->sigma_range = larger(echoes->rows.sigma_range[j], echoes->sigma_range);
        echoes->sigma_bearing = larger(echoes->rows.sigma_bearing[j], echoes->sigma_bearing);
    }
}

/* Where echoes may be inside the gates of n objects, (n,) each: by range, and by bearing so far to either side of one.
   */
typedef struct {
    double *nearest, *farthest, *middle, *to_port, *to_starboard;
} Windows;

/* Returns an angle wrapped to about [-pi, pi]: as `wrapped`, without a branch, for loops over many. */
static inline double turned(double angle)
{
    return angle - (2.0 * PI) * rint(angle / (2.0 * PI));
}

/* Returns the windows. The gate is an ellipse: nothing inside it is farther along or across the line of sight than the
   standard deviation there, of prediction and echo, times `gate`. */
static Windows windows_of(const Objects *objects, const Echoes *echoes, double gate)
{
    const int64_t n = objects->n;
    const Windows windows = {SCRATCH(double, n), SCRATCH(double, n), SCRATCH(double, n), SCRATCH(double, n),
                             SCRATCH(double, n)};
    double *restrict nearest = windows.nearest, *restrict farthest = windows.farthest;
    double *restrict to_port = windows.to_port, *restrict to_starboard = windows.to_starboard;
    double *restrict middle = windows.middle;
    for (int64_t i = 0; i < n; i++) {
        nearest[i] = INFINITY, farthest[i] = -INFINITY, middle[i] = objects->predicted.bearing[i];
        to_port[i] = to_starboard[i] = 0.0;
    }
    for (int64_t h = 0; h < objects->hypotheses; h++) {
        const PredictedMeasurement *predicted = &objects->predicted;
        const double *range_m = predicted->range_m + h * n, *along = predicted->along + h * n;
        const double *bearing = predicted->bearing + h * n, *across = predicted->across + h * n;
        const double *horizontal = predicted->horizontal + h * n;
        for (int64_t i = 0; i < n; i++) {
            const double far = gate * sqrt(along[i] + square(echoes->sigma_range));
            const double sideways = across[i] / square(horizontal[i]) + square(echoes->sigma_bearing);
            const double aside = ROUNDED * gate * sqrt(sideways);
            const double off_middle = turned(bearing[i] - middle[i]);
            nearest[i] = smaller(range_m[i] - far, nearest[i]);
            farthest[i] = larger(range_m[i] + far, farthest[i]);
            to_port[i] = larger(aside - off_middle, to_port[i]);
            to_starboard[i] = larger(aside + off_middle, to_starboard[i]);
        }
    }
    return windows;
}

/* Returns the first place in `sorted` whose number is not below `value`; without a branch that cannot be foreseen. */
static int64_t place_in(const double *sorted, int64_t count, double value)
{
    int64_t first = 0;
    while (count > 1) {
        const int64_t half = count / 2;
        first += sorted[first + half - 1] < value ? half : 0;
        count -= half;
    }
    return first + (count == 1 && sorted[first] < value);
}

/* Fills in the echoes that may be inside the gate of object i, by range; returns how many. */
static int64_t find_near(const Windows *windows, int64_t i, const Echoes *echoes, int64_t *near)
{
    const double farthest = windows->farthest[i], middle = windows->middle[i];
    const double to_port = windows->to_port[i], to_starboard = windows->to_starboard[i];
    int64_t count = 0;
    for (int64_t place = place_in(echoes->range_m, echoes->m, windows->nearest[i]); place < echoes->m; place++) {
        if (!(echoes->range_m[place] <= farthest))
            break;
        const double off = turned(echoes->bearing[place] - middle);
        const bool here = (-off <= to_port) & (off <= to_starboard);
        near[count] = echoes->order[place];
        count += here | ((2.0 * PI) - off <= to_port) | ((2.0 * PI) + off <= to_starboard);
    }
    return count;
}

/* Returns the log-likelihood ratio that echo j is of object i, or a false alarm; NAN where it is outside the gate. */
static double ratio_of(const Objects *objects, int64_t i, const Echoes *echoes, int64_t j, Gate gate,
                       Distance *distances)
{
    const double radius = objects->radius[i], radius_variance = objects->radius_variance[i];
    const double most = farthest_off(echoes->rows.cut[j], radius, radius_variance);
    double nearest = INFINITY, density = 0.0;
    for (int64_t h = 0; h < objects->hypotheses; h++) {
        distances[h] = distance_of(&objects->predicted, h * objects->n + i, &echoes->rows, j, most, 0.0);
        nearest = smaller(distances[h].square, nearest);
    }
    if (!(nearest <= square(gate.sigmas)))
        return NAN;
    for (int64_t h = 0; h < objects->hypotheses; h++)
        density += objects->weight[h * objects->n + i] * likelihood_of(distances[h]);
    if (echoes->rows.cut[j] != 0.0) {
        double again = 0.0;
        for (int64_t h = 0; h < objects->hypotheses; h++)
            again += objects->weight[h * objects->n + i] *
                     likelihood_of(distance_of(&objects->predicted, h * objects->n + i, &echoes->rows, j, most, KEPT));
        density = 0.5 * (density + again);
    }
    const double chance = density / (2.0 * PI) * gate.detection_probability / echoes->per_m2[j];
    const double difference = echoes->rows.radius[j] - radius;
    const double variance = radius_variance + square(echoes->rows.sigma_radius[j]);
    const double alike = -0.5 * (square(difference) / variance + log((2.0 * PI) * variance));
    /* a radius that does not agree never counts for more than a difference beyond chance: echoes merge, split and change */
    const double least = -0.5 * square(BEYOND_CHANCE);
    return log(larger(NOT_ZERO, chance)) + larger(least, alike - log(echoes->of_radius[j]));
}

/* Fills in the pairs of objects that are not `left_out` and echoes inside their gates, as far as there is room; returns
   how many there are. */
KERNEL_INT(
    gating_pairs,
    "f8[8,h,n] predicted, f8[h,n] weight, f8[n] radius, f8[n] radius_variance, f8[12,m] echo_table, f8[m] per_m2, "
    "f8[m] of_radius, f8[n] visibility, b1[n] left_out, float sigmas, float detection_probability, "
    "out i8[room] objects, out i8[room] echoes, out f8[room] llr, out f8[room] score")
{
    const int64_t n = SIZE(0, 2), m = SIZE(4, 1), room = SIZE(11, 0);
    const Objects objects = {.predicted = predicted_rows(ARRAY(double, 0), SIZE(0, 1) * n),
                             .weight = ARRAY(const double, 1),
                             .radius = ARRAY(const double, 2),
                             .radius_variance = ARRAY(const double, 3),
                             .hypotheses = SIZE(0, 1),
                             .n = n};
    Echoes echoes = {.rows = echo_rows(ARRAY(double, 4), m),
                     .per_m2 = ARRAY(const double, 5),
                     .of_radius = ARRAY(const double, 6),
                     .m = m};
    const Gate gate = {FLOAT(9), FLOAT(10)};
    const double *visibility = ARRAY(const double, 7);
    const bool *left_out = ARRAY(const bool, 8);
    int64_t *of_object = ARRAY(int64_t, 11), *of_echo = ARRAY(int64_t, 12), found = 0, *near = SCRATCH(int64_t, m + 1);
    double *llr = ARRAY(double, 13), *score = ARRAY(double, 14);
    Distance *distances = SCRATCH(Distance, objects.hypotheses);
    put_in_order(&echoes);
    const Windows windows = windows_of(&objects, &echoes, gate.sigmas);
    for (int64_t i = 0; i < n; i++) {
        const int64_t before = found, count = left_out[i] ? 0 : find_near(&windows, i, &echoes, near);
        for (int64_t k = 0; k < count; k++) {
            const double ratio = ratio_of(&objects, i, &echoes, near[k], gate, distances);
            if (isnan(ratio))
                continue;
            if (found < room)
                of_object[found] = i, of_echo[found] = near[k], llr[found] = ratio;
            found++;
        }
        const double over = found > before ? score_over_llr(visibility[i], gate.detection_probability) : 0.0;
        for (int64_t k = before; k < smaller_i(found, room); k++)
            score[k] = llr[k] + over;
    }
    return found;
}
