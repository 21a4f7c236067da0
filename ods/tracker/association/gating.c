/* Which echoes may be whose, and how well each pair inside the statistical gate explains the image (gating.py). */

#include "ods/tracker/association/gating.h"
#include "ods/tracker/measurement/cut_off.h"
#include "ods/tracker/measurement/model.h"

/* A radius that does not agree never counts for more than a 3-sigma difference: echoes merge, split and change. */
#define LEAST_RADIUS_RATIO (-4.5)
#define TWO_PI 6.28318530717958647692
/* Allows for rounding. */
#define ROUNDED (1.0 + 1e-9)

/* n objects by h hypotheses of motion. */
typedef struct {
    PredictedMeasurement predicted; /* (h, n) each */
    const double *weight;           /* (h, n) */
    const double *radius, *radius_variance;
    int64_t hypotheses, n;
} Objects;

/* m echoes, false alarms at each of them, and (m,) their order by range. */
typedef struct {
    EchoRows rows;
    const double *per_m2, *of_radius;
    const int64_t *order;
    const double *in_order; /* (m,) ranges */
    int64_t m;
} Echoes;

typedef struct {
    double sigmas, detection_probability;
} Gate;

typedef struct {
    double sigma_range, sigma_bearing;
} Largest;

/* A squared distance, in standard deviations, and the determinant, m^4, of the covariance that it is told by. */
typedef struct {
    double square, determinant;
} Distance;

/* Returns the distance of echo j from a hypothesis, k, of an object; `most`: largest variance, m^2, that the echo's place
   can have. */
static Distance distance_of(const PredictedMeasurement *predicted, int64_t k, const EchoRows *echoes, int64_t j, double most)
{
    const double horizontal = predicted->horizontal[k], s_mixed = predicted->mixed[k];
    const double along = echoes->range_m[j] - predicted->range_m[k];
    const double across = wrapped(echoes->bearing[j] - predicted->bearing[k]) * horizontal;
    const double s_along = predicted->along[k] + smaller(most, square(echoes->sigma_range[j]));
    const double s_across = predicted->across[k] + smaller(most, square(horizontal * echoes->sigma_bearing[j]));
    const double determinant = s_along * s_across - square(s_mixed);
    const double sum = s_across * square(along) - 2.0 * s_mixed * along * across + s_along * square(across);
    return (Distance){sum / determinant, determinant};
}

/* Returns the first place in `sorted` whose number is not below `value`, or with `after` is above it. */
static int64_t place_in(const double *sorted, int64_t count, double value, bool after)
{
    int64_t low = 0, high = count;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        if (after ? sorted[middle] <= value : sorted[middle] < value)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Where the echoes are that may be inside the gate of an object. */
typedef struct {
    int64_t first, last;          /* `order[first:last]` by range, */
    double middle;                /* and by bearing, rad: from this one */
    double to_port, to_starboard; /* so far to either side */
} Window;

/* Returns the window of object i; `largest`: echo of the largest sigmas of range and bearing.

   The gate is an ellipse: nothing inside it is farther along or across the line of sight than `width`. */
static Window window_of(const Objects *objects, int64_t i, const Echoes *echoes, Largest largest, double gate)
{
    const PredictedMeasurement *predicted = &objects->predicted;
    double low = INFINITY, high = -INFINITY;
    Window window = {0, 0, predicted->bearing[i], 0.0, 0.0};
    for (int64_t h = 0; h < objects->hypotheses; h++) {
        const int64_t k = h * objects->n + i;
        double width = gate * sqrt(predicted->along[k] + square(largest.sigma_range));
        low = smaller(predicted->range_m[k] - width, low);
        high = larger(predicted->range_m[k] + width, high);
        width = gate * sqrt(predicted->across[k] / square(predicted->horizontal[k]) + square(largest.sigma_bearing));
        const double off_middle = wrapped(predicted->bearing[k] - window.middle);
        window.to_port = larger(ROUNDED * width - off_middle, window.to_port);
        window.to_starboard = larger(ROUNDED * width + off_middle, window.to_starboard);
    }
    window.first = place_in(echoes->in_order, echoes->m, low, false);
    window.last = place_in(echoes->in_order, echoes->m, high, true);
    return window;
}

/* Tells whether a bearing may be inside the gate. */
static bool may_be_in(const Window *window, double bearing)
{
    const double off = wrapped(bearing - window->middle);
    const bool here = -off <= window->to_port && off <= window->to_starboard;
    return here || TWO_PI - off <= window->to_port || TWO_PI + off <= window->to_starboard;
}

/* Returns the log-likelihood ratio that echo j is of object i, or a false alarm; NAN where it is outside the gate. */
static double ratio_of(const Objects *objects, int64_t i, const Echoes *echoes, int64_t j, Gate gate, Distance *distances)
{
    const double radius = objects->radius[i], radius_variance = objects->radius_variance[i];
    const double most = farthest_off(echoes->rows.cut[j], radius, radius_variance);
    double nearest = INFINITY, density = 0.0;
    for (int64_t h = 0; h < objects->hypotheses; h++) {
        distances[h] = distance_of(&objects->predicted, h * objects->n + i, &echoes->rows, j, most);
        nearest = smaller(distances[h].square, nearest);
    }
    if (!(nearest <= square(gate.sigmas)))
        return NAN;
    for (int64_t h = 0; h < objects->hypotheses; h++)
        density += objects->weight[h * objects->n + i] * exp(-0.5 * distances[h].square) / sqrt(distances[h].determinant);
    const double chance = density / TWO_PI * gate.detection_probability / echoes->per_m2[j];
    const double difference = echoes->rows.radius[j] - radius;
    const double variance = radius_variance + square(echoes->rows.sigma_radius[j]);
    const double alike = -0.5 * (square(difference) / variance + log(TWO_PI * variance));
    return log(larger(IMPOSSIBLE, chance)) + larger(LEAST_RADIUS_RATIO, alike - log(echoes->of_radius[j]));
}

/* Fills in scores of pairs: see `gating.scored`. */
KERNEL(gating_score, "i8[p] objects, f8[p] llr, f8[n] visibility, float detection_probability, out f8[p] score")
{
    const int64_t *objects = ARRAY(const int64_t, 0);
    const double *llr = ARRAY(const double, 1), *visibility = ARRAY(const double, 2);
    double *score = ARRAY(double, 4);
    for (int64_t k = 0; k < SIZE(0, 0); k++) {
        const bool known = objects[k] >= 0 && objects[k] < SIZE(2, 0);
        score[k] = known ? llr[k] + score_over_llr(visibility[objects[k]], FLOAT(3)) : -INFINITY;
    }
}

/* Fills in the pairs of objects that are not `left_out` and echoes inside their gates, as far as there is room; returns
   how many there are. `order`: of the echoes by range. */
KERNEL_INT(gating_pairs,
           "f8[8,h,n] predicted, f8[h,n] weight, f8[n] radius, f8[n] radius_variance, f8[12,m] echo_table, f8[m] per_m2, "
           "f8[m] of_radius, i8[m] order, f8[n] visibility, b1[n] left_out, float sigmas, float detection_probability, "
           "out i8[room] objects, out i8[room] echoes, out f8[room] llr, out f8[room] score")
{
    const int64_t n = SIZE(0, 2), m = SIZE(4, 1), room = SIZE(12, 0), *order = ARRAY(const int64_t, 7);
    const Objects objects = {predicted_rows(ARRAY(double, 0), SIZE(0, 1) * n), ARRAY(const double, 1), ARRAY(const double, 2),
                             ARRAY(const double, 3), SIZE(0, 1), n};
    double *in_order = SCRATCH(double, m);
    Largest largest = {0.0, 0.0};
    const Echoes echoes = {echo_rows(ARRAY(double, 4), m), ARRAY(const double, 5), ARRAY(const double, 6), order, in_order, m};
    const Gate gate = {FLOAT(10), FLOAT(11)};
    int64_t *of_object = ARRAY(int64_t, 12), *of_echo = ARRAY(int64_t, 13), found = 0;
    double *llr = ARRAY(double, 14), *score = ARRAY(double, 15);
    Distance *distances = SCRATCH(Distance, objects.hypotheses);
    for (int64_t j = 0; j < m; j++) {
        in_order[j] = echoes.rows.range_m[order[j]];
        largest.sigma_range = larger(echoes.rows.sigma_range[j], largest.sigma_range);
        largest.sigma_bearing = larger(echoes.rows.sigma_bearing[j], largest.sigma_bearing);
    }
    for (int64_t i = 0; i < n; i++) {
        if (ARRAY(const bool, 9)[i])
            continue;
        const double over = score_over_llr(ARRAY(const double, 8)[i], gate.detection_probability);
        const Window window = window_of(&objects, i, &echoes, largest, gate.sigmas);
        for (int64_t place = window.first; place < window.last; place++) {
            if (!may_be_in(&window, echoes.rows.bearing[order[place]]))
                continue;
            const double ratio = ratio_of(&objects, i, &echoes, order[place], gate, distances);
            if (isnan(ratio))
                continue;
            if (found < room) {
                of_object[found] = i, of_echo[found] = order[place];
                llr[found] = ratio, score[found] = ratio + over;
            }
            found++;
        }
    }
    return found;
}
