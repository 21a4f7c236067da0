/* Does a track follow a real object? One model decides: this file.

   A track is in one of four hidden states:

       visible   an object that gives echoes
       silent    an object that gives none just now (its aspect, a shadow): missing some echoes is normal
       nothing   a chain of unrelated false alarms, or an object that is gone
       clutter   a place that shows echoes now and then without an object, as the highlights of a rough sea-bed do

   The first three are integrated probabilistic data association (IPDA; D. Musicki, R. Evans, S. Stankovic, IEEE Trans.
   Automatic Control 39(6), 1994, its second form). The fourth, persistent clutter, is what that model lacks before a
   sea-bed: a highlight comes back to its place, so chance explains its echoes no better than it explains an object's.

   Each scan goes through the same steps, for all tracks in one loop (`update_track`):

   1. Time passes (`predict`): an object may fall silent, return, or be lost.
   2. The scan had an echo for the track, or it had none where one was expected (`update`): Bayes' rule. An echo is
      e^llr times as likely from an object as from noise. To "nothing" and "silent", an echo is noise.
      How often a track is seen distinguishes an object from clutter. Neither rate is known beforehand: each is beta
      distributed and follows the track's own hits, so that the product over all scans is the ratio of two
      beta-binomial laws (J. G. Skellam, J. Royal Statistical Society B 10(2), 1948). The first echoes prove much, the
      hundredth next to nothing (`hit_rate_ratio`). From one place clutter is seen again as it was: of what rests, such
      a scan counts in part (`weight`), after the first few.
   3. What the echo looks like distinguishes an object from clutter, too, and so does motion. Features, in the table FEATURE:
        onset         how sharply the echo sets in: how many of a track's echoes are sharp, beta-binomial
        leading edge  how likely it sets in as an object does, by the pipeline's network: mean of the last log-odds,
                      normal
        motion        how likely the track's filter takes it to be at rest: clutter does not move
      Each keeps two sums a track (`update`), and turns them into one log-likelihood ratio (`log_ratio`). An echo
      replaces the ratio applied so far by the new one. Ratios are of the sums, not products over echoes: what lasts
      from scan to scan (a crest keeps its shape) must not count anew with each echo.
      All ratios are clamped, so that no feature alone decides.

   How much clutter there is differs from bed to bed, so it is learned (ClutterStatistics): its share from tracks that
   ended without having been objects, each weighted by its probability of clutter, its echoes a scan from those that no
   confirmed track explains. An object that is there teaches nothing: its track does not end.

   A new feature is one more line in FEATURE, its two functions, three rows of the table, and what is measured. */

#include "ods/tracker/association/hypotheses/gating.h"
#include "ods/tracker/existence/evidence.h"
#include "ods/tracker/existence/lifecycle.h"
#include "ods/tracker/measurement/scan.h"

/* Share of the tracks with one echo that each scan of their place ends, as errors of association; with more echoes
   there are fewer of these. */
#define YOUNG 0.045
/* A miss is never more certain than this. */
#define LEAST_MISSED 1e-3

/* `ExistenceModel` of model.py, which says what each is. */
typedef struct {
    double object_hit_rate, object_scans, clutter_hit_rate, clutter_scans, crowded_scans, crowd_a_second, crowd_power;
    double sharp, object_sharp, object_slow, clutter_sharp, clutter_slow;
    double most_ratio, onset_enough, odds_factor;
    double edge_limit, object_edge, clutter_edge, edge_variance, edge_few, edge_fade, edge_for;
    double motion_for;
    double new_share, many, share_tracks, memory;
} Model;

#define MODEL "f8[27] model"

/* What was counted: `values` of `ClutterStatistics`. Sums over the tracks that ended; the last scans, and their echoes
   that no confirmed track explains. */
typedef struct {
    double clutter_tracks, ended_tracks, scans, echoes;
} Counts;

#define COUNTS "f8[4] counts"

typedef struct {
    double visible, silent, nothing, clutter;
} State;

/* How often an object falls silent, gives echoes again, and is lost: 1/s each. */
typedef struct {
    double silence, recovery, loss;
} Rates;

/* How often a track has an echo, if it is an object and if it is clutter, over the setting's probability. */
typedef struct {
    double object, clutter;
} HitRates;

/* What is known beforehand of a scan's tracks. */
typedef struct {
    const Model *model;
    double clutter_share;
    double static_prior; /* probability that a new object is at rest */
} Prior;

/* --- The four states: IPDA --- */

static State normalized(double visible, double silent, double nothing, double clutter)
{
    const double total = visible + silent + nothing + clutter;
    return (State){visible / total, silent / total, nothing / total, clutter / total};
}

/* Returns the state `dt` seconds later.

   `watched`: share of the time that the track was in the sonar's view: only then does it fall silent, return, or get
   lost. `echoes`: so far. */
static State predict(State state, int64_t echoes, double watched, double dt, Rates rates)
{
    const double time = dt * watched;
    const double falls_silent = state.visible * -expm1(-rates.silence * time);
    const double returns = state.silent * -expm1(-rates.recovery * time);
    const double lost = -expm1(-(rates.loss * time + watched * YOUNG / (double)echoes));
    const double moved = returns - falls_silent;
    return (State){(1.0 - lost) * (state.visible + moved), (1.0 - lost) * (state.silent - moved),
                   state.nothing + lost * (state.visible + state.silent), state.clutter};
}

static double likelihood(double rate, double expected, double ratio)
{
    return larger(LEAST_MISSED, 1.0 - expected * rate) + ratio * rate;
}

/* Returns the state after a scan; `expected`: probability that a visible object of the setting's rate had an echo; `weight`:
   of the scan, between an object and clutter. */
static State update(State state, bool hit, double llr, double expected, HitRates rates, double weight)
{
    const double ratio = hit ? exp(smaller(MOST_RATIO, llr)) : 0.0;
    const double object = likelihood(rates.object, expected, ratio), clutter = likelihood(rates.clutter, expected, ratio);
    return normalized(state.visible * object, state.silent, state.nothing,
                      state.clutter * object * (weight < 1.0 ? pow(clutter / object, weight) : clutter / object));
}

/* Returns the state given a log-likelihood ratio of an object over persistent clutter. */
static State apply_likelihood_ratio(State state, double ratio)
{
    return ratio == 0.0 ? state : normalized(state.visible, state.silent, state.nothing, state.clutter * exp(-ratio));
}

/* --- Hit rate --- */

/* Returns the rates by a track's hits in a number of scans: means of the beta laws given these. */
static HitRates hit_rate_ratio(double hits, double scans, double detection_probability, double crowding, const Model *m)
{
    const double weight = m->clutter_scans + crowding * (m->crowded_scans - m->clutter_scans);
    const double object = (hits + m->object_scans * m->object_hit_rate) / (scans + m->object_scans);
    const double clutter = (hits + weight * m->clutter_hit_rate) / (scans + weight);
    return (HitRates){object / detection_probability, clutter / detection_probability};
}

/* Returns how crowded clutter is, 0 to 1: among hundreds of highlights a second some are seen nearly always. */
static double crowding_of(double echoes, double dt, const Model *m)
{
    if (!(echoes > 0.0 && dt > 0.0))
        return 0.0;
    return 1.0 / (1.0 + pow(m->crowd_a_second * dt / echoes, m->crowd_power));
}

/* --- Features of echoes --- */

static double log_beta(double a, double b)
{
    return lgamma(a) + lgamma(b) - lgamma(a + b);
}

static void update_onset(double *sum, double *count, double echo, const Prior *prior)
{
    *sum += echo < prior->model->sharp;
    *count += 1.0;
}

/* Beta-binomial: `sum` of `count` echoes are sharp. */
static double onset_ratio(double sum, double count, const Prior *prior)
{
    const Model *m = prior->model;
    const double slow = count - sum;
    const double object = log_beta(m->object_sharp + sum, m->object_slow + slow) -
                          log_beta(m->object_sharp, m->object_slow);
    const double clutter = log_beta(m->clutter_sharp + sum, m->clutter_slow + slow) -
                           log_beta(m->clutter_sharp, m->clutter_slow);
    const double least = count >= m->onset_enough ? -INFINITY : 0.0;
    return smaller(m->most_ratio, larger(least, object - clutter));
}

static void update_edge(double *sum, double *count, double echo, const Prior *prior)
{
    const Model *m = prior->model;
    const double share = smaller(1.0 - m->edge_limit, larger(m->edge_limit, echo));
    *sum = m->edge_fade * *sum + log(share / (1.0 - share));
    *count = m->edge_fade * *count + 1.0;
}

/* Normal: the mean of n log-odds has a variance of `edge_variance` (1 + `edge_few` / n) for either. */
static double edge_ratio(double sum, double count, const Prior *prior)
{
    const Model *m = prior->model;
    const double over = sum - 0.5 * (m->object_edge + m->clutter_edge) * count;
    const double ratio = (m->object_edge - m->clutter_edge) * over / (m->edge_variance * (count + m->edge_few));
    return smaller(m->edge_for, larger(-m->most_ratio, ratio));
}

/* The last value counts: the filter has put all echoes together. */
static void update_motion(double *sum, double *count, double at_rest, const Prior *prior)
{
    (void)prior;
    *sum = at_rest;
    *count = 1.0;
}

static double motion_ratio(double sum, double count, const Prior *prior)
{
    return count == 0.0 ? 0.0 : smaller(prior->model->motion_for, larger(0.0, log(prior->static_prior / sum)));
}

static const struct {
    void (*update)(double *sum, double *count, double echo, const Prior *prior);
    double (*log_ratio)(double sum, double count, const Prior *prior);
    bool spares_confirmed; /* is not held against a confirmed track */
} FEATURE[FEATURES] = {
    [ONSET] = {update_onset, onset_ratio, true},
    [LEADING_EDGE] = {update_edge, edge_ratio, true},
    [MOTION] = {update_motion, motion_ratio, false},
};

/* Returns the state of track i given what was measured of each feature, number k of these; NULL: of none. */
static State apply_features(const ExistenceTable *tracks, int64_t i, State state,
                            const double *const measured[FEATURES], int64_t k, bool confirmed, const Prior *prior)
{
    for (int f = 0; f < FEATURES; f++) {
        if (!measured[f] || !(measured[f][k] > 0.0))
            continue;
        double *sum = tracks->features[f].sum + i, *count = tracks->features[f].count + i;
        FEATURE[f].update(sum, count, measured[f][k], prior);
        const double ratio = FEATURE[f].log_ratio(*sum, *count, prior);
        const double change = ratio - tracks->features[f].ratio[i];
        if (confirmed && FEATURE[f].spares_confirmed && change < 0.0)
            continue;
        tracks->features[f].ratio[i] = ratio;
        state = apply_likelihood_ratio(state, change);
    }
    return state;
}

/* --- Clutter statistics --- */

static double echoes_a_scan(const Counts *counts)
{
    return counts->echoes / larger(counts->scans, 1.0);
}

/* Added to the square of the echoes a scan: there is persistent clutter in water without an echo, too. */
#define CALM 0.1

/* Returns the share of persistent clutter; what is known beforehand counts for so many tracks. */
static double clutter_share_of(const Counts *counts, const Model *m)
{
    const double echoes = square(echoes_a_scan(counts));
    const double prior = m->new_share * (CALM + echoes) / (square(m->many) + echoes);
    return (counts->clutter_tracks + m->share_tracks * prior) / (counts->ended_tracks + m->share_tracks);
}

/* Counts the `is_free` echoes, those that no confirmed track explains, if they measure a strength. */
KERNEL(clutter_count_echoes, "out " COUNTS ", f8[12,m] echoes, b1[m] free, " MODEL)
{
    Counts *counts = ARRAY(Counts, 0);
    const EchoRows echoes = echo_rows(ARRAY(double, 1), SIZE(1, 1));
    const bool *is_free = ARRAY(const bool, 2);
    const double memory = ARRAY(const Model, 3)->memory;
    counts->scans = memory * counts->scans + 1.0;
    counts->echoes *= memory;
    for (int64_t j = 0; j < SIZE(1, 1); j++)
        counts->echoes += is_free[j] && echoes.strength[j] > 0.0;
}

/* Returns how many of the first `most` echoes differ by less than so much from one of the scan before. */
KERNEL_INT(count_same_echoes, "f8[12,m] now, f8[12,n] before, int most, float range_m, float bearing_rad, "
                              "float strength_db")
{
    const EchoRows now = echo_rows(ARRAY(double, 0), SIZE(0, 1)), before = echo_rows(ARRAY(double, 1), SIZE(1, 1));
    const double range_m = FLOAT(3), bearing_rad = FLOAT(4), strength_db = FLOAT(5);
    int64_t count = 0;
    for (int64_t j = 0; j < smaller_i(SIZE(0, 1), INT(2)); j++) {
        int64_t same = 0;
        for (int64_t k = 0; k < SIZE(1, 1); k++)
            same |= (fabs(now.range_m[j] - before.range_m[k]) < range_m)
                    & (fabs(now.bearing[j] - before.bearing[k]) < bearing_rad)
                    & (fabs(now.strength[j] - before.strength[k]) < strength_db);
        count += same;
    }
    return count;
}

/* Learns from the tracks that a scan `ended`. Called for every scan: what was counted before fades. */
KERNEL(clutter_learn, "out " COUNTS ", f8[17,n] tracks, b1[n] ended, " MODEL)
{
    Counts *counts = ARRAY(Counts, 0);
    const ExistenceTable tracks = existence_rows(ARRAY(double, 1), SIZE(1, 1));
    const bool *ended = ARRAY(const bool, 2);
    const Model *m = ARRAY(const Model, 3);
    counts->clutter_tracks *= m->memory, counts->ended_tracks *= m->memory;
    for (int64_t i = 0; i < SIZE(1, 1); i++) {
        if (!ended[i])
            continue;
        const double clutter = tracks.clutter[i];
        counts->clutter_tracks += clutter, counts->ended_tracks += clutter + tracks.nothing[i];
    }
}

/* --- All tracks of a scan --- */

static State state_of(const ExistenceTable *tracks, int64_t i)
{
    return (State){tracks->visible[i], tracks->silent[i], tracks->nothing[i], tracks->clutter[i]};
}

static void keep(const ExistenceTable *tracks, int64_t i, State state)
{
    tracks->visible[i] = state.visible, tracks->silent[i] = state.silent;
    tracks->nothing[i] = state.nothing, tracks->clutter[i] = state.clutter;
}

/* Sets tracks from `first` on, one an unexplained echo, given births a scan and false alarms a scan at each. */
KERNEL(existence_begin,
       "out f8[17,n] tracks, int first, float births, f8[k] density, f8[12,k] echoes, " COUNTS ", " MODEL)
{
    const int64_t first = INT(1), n = SIZE(0, 1);
    const ExistenceTable tracks = existence_rows(ARRAY(double, 0), n);
    const double births = FLOAT(2), *density = ARRAY(const double, 3);
    const EchoRows echoes = echo_rows(ARRAY(double, 4), SIZE(4, 1));
    const double *const measured[FEATURES] = {echoes.onset, echoes.front};
    const Model *m = ARRAY(const Model, 6);
    const Prior prior = {.model = m, .clutter_share = clutter_share_of(ARRAY(const Counts, 5), m)};
    for (int64_t k = 0; k < SIZE(3, 0) && first + k < n; k++) {
        const int64_t i = first + k;
        const double none = density[k] / (births + density[k]);
        const State state = {1.0 - none, 0.0, (1.0 - prior.clutter_share) * none, prior.clutter_share * none};
        tracks.clutter_share[i] = prior.clutter_share;
        keep(&tracks, i, apply_features(&tracks, i, state, measured, k, false, &prior));
        tracks.first_visible[i] = tracks.visible[i];
    }
}

static double logit(double share)
{
    return log(share / (1.0 - share));
}

/* What is the same for all tracks of a scan, `dt` s after the one before. */
typedef struct {
    double dt, detection_probability, crowding;
    double weight; /* of the scan */
    Rates rates;
    const double *const *measured; /* of each feature, (n,) */
} OfScan;

static void update_track(const ExistenceTable *tracks, int64_t i, const ScanEvidence *evidence, int64_t echoes,
                         bool hit, bool confirmed, const OfScan *of, const Prior *prior)
{
    const double *at_rest = of->measured[MOTION];
    const double watched = evidence->watched[i], share = prior->clutter_share;
    State state = predict(state_of(tracks, i), echoes, watched, of->dt, of->rates);
    const HitRates rates = hit_rate_ratio(tracks->hits[i], tracks->scans[i], of->detection_probability, of->crowding,
                                          prior->model);
    const double weight = tracks->scans[i] < prior->model->object_scans ? 1.0 : larger(of->weight, 1.0 - at_rest[i]);
    state = update(state, hit, evidence->llr[i], evidence->expected[i], rates, weight);
    state = apply_features(tracks, i, state, of->measured, i, confirmed, prior);
    if (confirmed && share != tracks->clutter_share[i]) {
        /* what was confirmed before any clutter was known is judged by what is known now */
        state = apply_likelihood_ratio(state, logit(tracks->clutter_share[i]) - logit(share));
        tracks->clutter_share[i] = share;
    }
    keep(tracks, i, state);
    tracks->hits[i] += hit ? weight : 0.0;
    tracks->scans[i] += weight * (hit ? 1.0 : watched);
}

/* Updates n tracks by a scan, `dt` seconds after the one before; `weight`: of the scan (`Coherence`). */
KERNEL(existence_update,
       "out f8[17,n] tracks, i8[n] echoes, b1[n] confirmed, b1[n] hit, f8[5,n] evidence, f8[n] static, float dt, "
       "float weight, float silence, float recovery, float loss, float detection_probability, float static_prior, " COUNTS
       ", " MODEL)
{
    const int64_t n = SIZE(0, 1), *echoes = ARRAY(const int64_t, 1);
    const ExistenceTable tracks = existence_rows(ARRAY(double, 0), n);
    const bool *confirmed = ARRAY(const bool, 2), *hit = ARRAY(const bool, 3);
    const ScanEvidence evidence = evidence_rows(ARRAY(double, 4), n);
    const double *const measured[FEATURES] = {evidence.onset, evidence.leading_edge, ARRAY(const double, 5)};
    const double dt = FLOAT(6);
    const Counts *counts = ARRAY(const Counts, 13);
    const Model *m = ARRAY(const Model, 14);
    const Prior prior = {m, clutter_share_of(counts, m), FLOAT(12)};
    const OfScan of = {dt, FLOAT(11), crowding_of(echoes_a_scan(counts), dt, m), FLOAT(7), {FLOAT(8), FLOAT(9), FLOAT(10)},
                       measured};
    for (int64_t i = 0; i < n; i++)
        update_track(&tracks, i, &evidence, echoes[i], hit[i], confirmed[i], &of, &prior);
}

/* --- What became of the tracks --- */

/* Takes note that the objects `rows` were seen. */
KERNEL(tracks_seen, "out i8[8,n] history, i8[k] rows, int t_ns, int utc_ns")
{
    const int64_t n = SIZE(0, 1), *rows = ARRAY(const int64_t, 1);
    const History history = history_rows(ARRAY(int64_t, 0), n);
    for (int64_t k = 0; k < SIZE(1, 0); k++) {
        const int64_t i = rows[k];
        if (i < 0 || i >= n)
            continue;
        history.echoes[i]++;
        history.last[i] = INT(2);
        history.last_utc[i] = INT(3);
        history.unwatched[i] = 0;
    }
}

/* Sets tentative objects from `first` on, seen once. */
KERNEL(tracks_begin, "out i8[8,n] history, int first, int t_ns, int utc_ns")
{
    const int64_t n = SIZE(0, 1);
    const History history = history_rows(ARRAY(int64_t, 0), n);
    for (int64_t i = larger_i(INT(1), 0); i < n; i++) {
        history.state[i] = TENTATIVE;
        history.echoes[i] = 1;
        history.born[i] = history.last[i] = INT(2);
        history.first_utc[i] = history.last_utc[i] = INT(3);
    }
}

/* --- The next states --- */

/* What is known of n objects: fields of `Estimate`, (3, n) and (n,), and probabilities from which on one does not move. */
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
            .unseen_s = seconds(unseen_ns),
            .missed_s = seconds(unseen_ns - history.unwatched[i]),
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
