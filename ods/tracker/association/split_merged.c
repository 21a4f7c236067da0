/* Several echoes of a large object, one echo of two close objects (split_merged.py). */

#include "ods/tracker/association/gating.h"
#include "ods/tracker/measurement/model.h"

/* The echo of two objects at one place is off the centre of each by at least this. */
#define SMALLEST_OFFSET_M 1e-3

/* Returns which of `some` of n objects has the circle that echo j is deepest inside of; -1: none. */
static int64_t whole_of(const EchoRows *echoes, int64_t j, const PredictedMeasurement *predicted, const double *radius, int64_t n,
                        const int64_t *some, int64_t count)
{
    double deepest = 0.0;
    int64_t whole = -1;
    for (int64_t k = 0; k < count; k++) {
        const int64_t i = some[k];
        if (i < 0 || i >= n)
            continue;
        const double along = echoes->range_m[j] - predicted->range_m[i];
        if (!(fabs(along) < radius[i]))
            continue;
        const double across = wrapped(echoes->bearing[j] - predicted->bearing[i]) * predicted->horizontal[i];
        const double excess = sqrt(square(along) + square(across)) - radius[i];
        if (excess < deepest)
            deepest = excess, whole = i;
    }
    return whole;
}

/* Fills in pairs of an object and a loose echo inside its circle; returns how many: see `parts_inside`. */
KERNEL_INT(parts_inside,
           "f8[8,n] predicted, f8[n] radius, f8[12,m] echo_table, i8[k] some, i8[l] loose, out i8[l] wholes, out i8[l] parts")
{
    const int64_t n = SIZE(0, 1), m = SIZE(2, 1);
    const PredictedMeasurement predicted = predicted_rows(ARRAY(double, 0), n);
    const EchoRows echoes = echo_rows(ARRAY(double, 2), m);
    const int64_t *loose = ARRAY(const int64_t, 4);
    int64_t *wholes = ARRAY(int64_t, 5), *parts = ARRAY(int64_t, 6), found = 0;
    for (int64_t k = 0; k < SIZE(4, 0); k++) {
        const int64_t j = loose[k];
        if (j < 0 || j >= m)
            continue;
        const int64_t whole = whole_of(&echoes, j, &predicted, ARRAY(const double, 1), n, ARRAY(const int64_t, 3), SIZE(3, 0));
        if (whole >= 0) {
            wholes[found] = whole;
            parts[found++] = j;
        }
    }
    return found;
}

/* Puts the echoes of each object of the pairs together: fills in k objects, their best log-likelihood ratios, and middle
   echoes, (12, k) from the first number on; returns k. `n`: how many objects there are. */
KERNEL_INT(put_together,
           HYPOTHESES ", f8[12,m] echo_table, int n, out i8[p] wholes, out f8[p] best, out f8[12,p] middles")
{
    const Hypotheses pairs = hypotheses_from(arguments, 0);
    const double *table = ARRAY(const double, 4);
    const int64_t m = SIZE(4, 1), n = larger_i(INT(5), 0);
    int64_t *wholes = ARRAY(int64_t, 6), *first = SCRATCH(int64_t, pairs.count), *place = SCRATCH(int64_t, n), k = 0;
    double *best = ARRAY(double, 7), *count = ZEROS(double, pairs.count);
    double *range_m = ZEROS(double, pairs.count), *bearing = ZEROS(double, pairs.count);
    memset(place, -1, (size_t)n * sizeof *place);
    for (int64_t pair = 0; pair < pairs.count; pair++) {
        if (!is_pair(&pairs, pair, n, m))
            continue;
        const int64_t i = pairs.objects[pair], j = pairs.echoes[pair];
        if (place[i] < 0) {
            place[i] = k;
            wholes[k] = i, first[k] = j, best[k] = pairs.llr[pair];
            k++;
        }
        best[place[i]] = larger(pairs.llr[pair], best[place[i]]);
        range_m[place[i]] += table[j];
        bearing[place[i]] += table[m + j];
        count[place[i]] += 1.0;
    }
    double *middles = ARRAY(double, 8);
    const EchoRows middle = echo_rows(middles, k);
    for (int64_t row = 0; row < SIZE(4, 0); row++)
        for (int64_t whole = 0; whole < k; whole++)
            middles[row * k + whole] = table[row * m + first[whole]];
    for (int64_t whole = 0; whole < k; whole++) {
        middle.range_m[whole] = range_m[whole] / count[whole];
        middle.bearing[whole] = bearing[whole] / count[whole];
    }
    return k;
}

/* Fills in the variance, m^2, by which each echo may lie off its object's centre because it is of two objects: see
   `merged_variance`. */
KERNEL(merged_variance,
       "f8[3,n] position, f8[n] radius, b1[n] hit, b1[n] reported, f8[n] watched, out f8[n] variance")
{
    const int64_t n = SIZE(1, 0);
    const double *north = ARRAY(const double, 0), *east = north + n, *radius = ARRAY(const double, 1);
    const bool *hit = ARRAY(const bool, 2), *reported = ARRAY(const bool, 3);
    const double *watched = ARRAY(const double, 4);
    double *variance = ARRAY(double, 5);
    int64_t *unseen = SCRATCH(int64_t, n), count = 0;
    for (int64_t i = 0; i < n; i++) {
        variance[i] = 0.0;
        if (reported[i] && watched[i] > 0.0 && !hit[i])
            unseen[count++] = i;
    }
    for (int64_t i = 0; i < n; i++) {
        if (!(reported[i] && watched[i] > 0.0 && hit[i]))
            continue;
        for (int64_t k = 0; k < count; k++) {
            const int64_t j = unseen[k];
            const double apart = sqrt(square(north[i] - north[j]) + square(east[i] - east[j]));
            if (!(apart < radius[i] + radius[j]))
                continue;
            const double half = square(larger(0.5 * apart, SMALLEST_OFFSET_M));
            variance[i] = larger(half, variance[i]);
            variance[j] = larger(half, variance[j]);
        }
    }
}
