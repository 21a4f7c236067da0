/* What of the live objects has been silent for long: it is not looked for behind others, and takes no single echo. */

#include "ods/tracker/existence/evidence.h"
#include "ods/tracker/existence/lifecycle.h"
#include "ods/tracker/measurement/model.h"

/* A silent object whose place is less certain than this, m, is vague. */
#define VAGUE_M 1.0
/* An object seen more recently than this, s, is not silent; one behind another is then seen over it or beside it. */
#define UNSEEN_S 0.5

/* Objects that may hide others: where their shadows begin, and in which bearings. */
typedef struct {
    double *behind_m, *bearing, *half_width;
    int64_t count;
} Fronts;

/* Returns the active objects as seen from the sonar; a shadow is as wide as the object. */
static Fronts fronts_of(PredictedMeasurement predicted, const double *radius, const int64_t *state, int64_t n)
{
    Fronts fronts = {SCRATCH(double, n), SCRATCH(double, n), SCRATCH(double, n), 0};
    for (int64_t i = 0; i < n; i++)
        if (state[i] == ACTIVE) {
            fronts.behind_m[fronts.count] = predicted.range_m[i] + radius[i];
            fronts.bearing[fronts.count] = predicted.bearing[i];
            fronts.half_width[fronts.count++] = asin(smaller(radius[i] / predicted.range_m[i], 1.0));
        }
    return fronts;
}

/* Tells whether an object is predicted behind a nearer one; shadows are the standard deviation of its bearing wider. */
static bool is_occluded(PredictedMeasurement predicted, int64_t i, Fronts fronts)
{
    const double distance = predicted.range_m[i], bearing = predicted.bearing[i];
    const double sigma = sqrt(predicted.across[i]) / predicted.horizontal[i];
    for (int64_t k = 0; k < fronts.count; k++)
        if (distance > fronts.behind_m[k] && fabs(bearing - fronts.bearing[k]) <= fronts.half_width[k] + sigma)
            return true;
    return false;
}

/* Sets which objects are confirmed, and which of those are vague; those silent behind an active one are not watched.
   `visibility`: that an object, if it exists, is in view, `probability`, and gives echoes, as silent ones do that have
   `returned`. */
KERNEL(judge_silent,
       "i8[8,n] history, f8[17,n] existence, f8[8,n] predicted, f8[n] radius, f8[n] probability, int t_ns, float returned, "
       "out b1[2,n] flags, out f8[n] watched, out f8[n] visibility")
{
    const int64_t n = SIZE(0, 1), t_ns = INT(5);
    const ExistenceTable tracks = existence_rows(ARRAY(double, 1), n);
    const History history = history_rows(ARRAY(int64_t, 0), n);
    const PredictedMeasurement predicted = predicted_rows(ARRAY(double, 2), n);
    const double *radius = ARRAY(const double, 3), *probability = ARRAY(const double, 4), returned = FLOAT(6);
    bool *reported = ARRAY(bool, 7), *vague = reported + n;
    double *watched = ARRAY(double, 8), *visibility = ARRAY(double, 9);
    Fronts fronts = {.count = -1};
    for (int64_t i = 0; i < n; i++) {
        reported[i] = history.state[i] != TENTATIVE;
        const bool silent = reported[i] && seconds(t_ns - history.last[i]) > UNSEEN_S;
        vague[i] = silent && larger(predicted.along[i], predicted.across[i]) > square(VAGUE_M);
        if (silent && fronts.count < 0)
            fronts = fronts_of(predicted, radius, history.state, n);
        if (silent && is_occluded(predicted, i, fronts))
            watched[i] = 0.0;
        const double exists = larger(tracks.visible[i] + tracks.silent[i], NOT_ZERO);
        visibility[i] = (tracks.visible[i] + tracks.silent[i] * returned) / exists * probability[i];
    }
}
