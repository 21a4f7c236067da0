/* What an image shows of each object, and which echoes no confirmed object explains (match.py). */

#include "ods/tracker/association/gating.h"
#include "ods/tracker/measurement/model.h"
#include "ods/tracker/track/doubt.h"

/* An echo that is so many times as wide as its object, taken to have at least this radius, is joined with neighbours': it
   sets in as the first of these does. */
#define JOINED 1.6
#define LEAST_JOINED_M 1.5

/* Tells which of m echoes no confirmed object explains, by pairs of object and echo. */
KERNEL(match_not_of_confirmed, "i8[p] objects, i8[p] echoes, b1[n] reported, out b1[m] free")
{
    const Hypotheses pairs = {ARRAY(const int64_t, 0), ARRAY(const int64_t, 1), NULL, NULL, SIZE(0, 0)};
    const int64_t n = SIZE(2, 0), m = SIZE(3, 0);
    const bool *reported = ARRAY(const bool, 2);
    bool *is_free = ARRAY(bool, 3);
    memset(is_free, 1, (size_t)m * sizeof *is_free);
    for (int64_t k = 0; k < pairs.count; k++)
        if (is_pair(&pairs, k, n, m) && reported[pairs.objects[k]])
            is_free[pairs.echoes[k]] = false;
}

/* Sets of the look at object i what its echo k tells; `alone`: the echo can be of no other object, and is all of it. */
static void look_at_echo(const Look *look, int64_t i, const EchoRows *echoes, int64_t k, double expected_m, double radius, bool alone)
{
    look->strength[i] = echoes->strength[k];
    if (!alone || !(echoes->strength[k] > 0.0))
        return;
    const bool joined = echoes->radius[k] > JOINED * larger(LEAST_JOINED_M, radius);
    look->off_range[i] = echoes->range_m[k] - expected_m;
    look->onset[i] = joined ? 0.0 : echoes->onset[k];
    look->front[i] = joined ? 0.0 : echoes->front[k];
}

/* Fills in the table of `Look`.

   Of k objects seen, each once: their echoes, log-likelihood ratios, and variance by which an echo may lie off the centre.
   Of n objects: `merged_variance`, where a missing echo may be in that of a neighbour; `watched` of the field of view,
   confirmed, hit, inside and not skipped; the predicted measurements, and radii. */
KERNEL(match_look,
       "i8[k] objects, f8[12,k] echo_table, f8[k] llr, f8[k] off_centre, f8[n] merged, f8[n] watched, b1[n] reported, "
       "b1[n] hit, b1[n] in_view, f8[8,n] predicted, f8[n] radius, float detection_probability, out f8[7,n] look")
{
    const int64_t k_count = SIZE(0, 0), n = SIZE(4, 0), *objects = ARRAY(const int64_t, 0);
    const EchoRows echoes = echo_rows(ARRAY(double, 1), k_count);
    const double *llr = ARRAY(const double, 2), *off_centre = ARRAY(const double, 3), *merged = ARRAY(const double, 4);
    const double *watched = ARRAY(const double, 5), *radius = ARRAY(const double, 10);
    const bool *reported = ARRAY(const bool, 6), *hit = ARRAY(const bool, 7), *in_view = ARRAY(const bool, 8);
    const PredictedMeasurement predicted = predicted_rows(ARRAY(double, 9), n);
    const Look look = look_rows(ARRAY(double, 12), n);
    memset(look.llr, 0, sizeof(double) * 7 * (size_t)n);
    for (int64_t i = 0; i < n; i++) {
        if (hit[i] || merged[i] == 0.0)
            look.watched[i] = reported[i] ? watched[i] : in_view[i];
        look.expected[i] = look.watched[i] * FLOAT(11);
        look.off_range[i] = NAN;
    }
    for (int64_t k = 0; k < k_count; k++) {
        const int64_t i = objects[k];
        if (i < 0 || i >= n)
            continue;
        const bool alone = off_centre[k] == 0.0 && merged[i] == 0.0 && echoes.cut[k] == 0.0;
        look.llr[i] = llr[k];
        look_at_echo(&look, i, &echoes, k, predicted.range_m[i], radius[i], alone);
    }
}
