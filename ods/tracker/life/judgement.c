/* Which state follows for each object from what an image proves of it (judgement.py). */

#include "ods/tracker/existence/evidence.h"
#include "ods/tracker/existence/lifecycle.h"
#include "ods/tracker/track/stitching.h"

#define NS_A_SECOND 1e9

/* What is known of n objects: fields of `Estimate`, (3, n) and (n,), and probabilities from which on one does not move.
   */
typedef struct {
    const double *position, *variance, *shared, *radius, *is_static;
    int64_t n;
    double at_rest, surely_at_rest;
} Known;

/* What the image shows of them: (n,) each. */
typedef struct {
    const bool *hit, *inside, *skipped;
} Shown;

/* Returns the larger standard deviation of north and east; of one at rest without what all pings share. */
static double sigma_of(const Known *known, int64_t i)
{
    const double moving = 1.0 - known->is_static[i];
    const double north = known->variance[i] + moving * known->shared[i];
    const double east = known->variance[known->n + i] + moving * known->shared[known->n + i];
    return sqrt(larger(east, north));
}

/* Finds the confirmed objects that the image does not show, and those at rest that it does. One that sleeps is not
   missed: it counts as seen when it was recalled from the map, not when it was. */
static void find_missed_and_hiding(const History *history, const Known *known, const bool *hit, Some *missed,
                                   Some *hiding)
{
    int64_t *of_missed = SCRATCH(int64_t, known->n), *of_hiding = SCRATCH(int64_t, known->n);
    *missed = (Some){of_missed, 0}, *hiding = (Some){of_hiding, 0};
    for (int64_t i = 0; i < known->n; i++) {
        if ((history->state[i] == ACTIVE || history->state[i] == STAND_BY) && !hit[i])
            of_missed[missed->count++] = i;
        if (history->state[i] == ACTIVE && hit[i] && known->is_static[i] >= known->surely_at_rest)
            of_hiding[hiding->count++] = i;
    }
}

/* Fills in the next states, and whether any object is lost out of view, is confirmed, and ends or rests once confirmed;
   `odds_factor`: of `ExistenceModel`; `rest`, `static_from`: `REST` and `STATIC` of the
   settings. */
KERNEL(next_states,
       "i8[8,n] history, f8[17,n] existence, b1[n] hit, b1[n] inside, b1[n] skipped, f8[3,n] position, f8[3,n] variance, "
       "f8[3,n] shared, f8[n] radius, f8[n] static, int t_ns, float odds_factor, float rest, "
       "float static_from, " LIFE_LIMITS ", out i8[n] states, out b1[3] events")
{
    const int64_t n = SIZE(0, 1), t_ns = INT(10);
    const History history = history_rows(ARRAY(int64_t, 0), n);
    const ExistenceTable tracks = existence_rows(ARRAY(double, 1), n);
    const Shown shown = {ARRAY(const bool, 2), ARRAY(const bool, 3), ARRAY(const bool, 4)};
    const Known known = {.position = ARRAY(const double, 5),
                         .variance = ARRAY(const double, 6),
                         .shared = ARRAY(const double, 7),
                         .radius = ARRAY(const double, 8),
                         .is_static = ARRAY(const double, 9),
                         .n = n,
                         .at_rest = FLOAT(12),
                         .surely_at_rest = FLOAT(13)};
    const Circles circles = {known.position, known.position + n, known.radius};
    const LifeLimits limits = limits_from(arguments, 14);
    int64_t *states = ARRAY(int64_t, 21);
    bool *events = ARRAY(bool, 22), *lost = events, *confirmed = events + 1, *for_the_map = events + 2;
    Some missed, hiding;
    memset(events, 0, 3 * sizeof *events);
    find_missed_and_hiding(&history, &known, shown.hit, &missed, &hiding);
    for (int64_t i = 0; i < n; i++) {
        const int64_t state = history.state[i], unseen_ns = t_ns - history.last[i];
        const bool rests = state == STAND_BY && known.is_static[i] >= known.surely_at_rest;
        const bool young = state == TENTATIVE && shown.hit[i];
        const Evidence evidence = {
            .hit = shown.hit[i],
            .inside = shown.inside[i],
            .skipped = shown.skipped[i],
            .echoes = history.echoes[i],
            .unseen_s = (double)unseen_ns / NS_A_SECOND,
            .missed_s = (double)(unseen_ns - history.unwatched[i]) / NS_A_SECOND,
            .existence = state == TENTATIVE ? confirmation_probability(&tracks, i, FLOAT(11))
                                            : tracks.visible[i] + tracks.silent[i],
            .visible = tracks.visible[i],
            .first_visible = tracks.first_visible[i],
            .is_static = known.is_static[i] >= known.at_rest,
            .covered = rests && is_covered(i, hiding, &circles),
            .duplicate = young && is_duplicate(i, missed, &history, &circles),
            .sigma = sigma_of(&known, i),
        };
        const int64_t after = states[i] = next_state_of(state, &evidence, &limits);
        *lost |= after == STAND_BY && !shown.inside[i];
        *confirmed |= state == TENTATIVE && after == ACTIVE;
        *for_the_map |= after == HIBERNATED || (after == TERMINATED && state != TENTATIVE);
    }
}
