/* Joint probabilistic data association: probabilities of pairs by belief propagation, and one echo for all that an
   object may have (jpda.py has where it is from). */

#include "ods/tracker/association/gnn.h"
#include "ods/tracker/measurement/model.h"

/* Most rounds of messages, */
#define ROUNDS 20
/* and the largest change of a message, all between 0 and 1, with which they end. */
#define CONVERGED 1e-3
/* An echo with less than this share of the probability of an object's most probable one is no rival of it. */
#define RIVAL 0.1

/* Pairs and their probabilities, (count,) each. */
typedef struct {
    const int64_t *objects, *echoes;
    const double *llr, *score;
    double *share; /* of the pair */
    double *free;  /* that its echo is of no other object */
    int64_t count;
} Pairs;

static void fill(double *numbers, int64_t count, double value)
{
    for (int64_t k = 0; k < count; k++)
        numbers[k] = value;
}

/* Sets `of_object`, (n,), to 1 and the sum of what its pairs are worth: their odds where nobody else takes the echo. */
static void add_up_worth(const Pairs *pairs, const double *ratio, double *of_object, int64_t n)
{
    fill(of_object, n, 1.0);
    for (int64_t k = 0; k < pairs->count; k++)
        of_object[pairs->objects[k]] += ratio[k] * pairs->free[k];
}

/* Sends the messages once; returns the largest change of one. Of an object to an echo: the odds that it takes it; of an
   echo to an object: that no other takes it. */
static double send_messages(const Pairs *pairs, const double *ratio, double *odds, double *of_object, double *of_echo,
                            int64_t n, int64_t m)
{
    double change = 0.0;
    add_up_worth(pairs, ratio, of_object, n);
    fill(of_echo, m, 1.0);
    for (int64_t k = 0; k < pairs->count; k++) {
        odds[k] = ratio[k] / larger(1.0, of_object[pairs->objects[k]] - ratio[k] * pairs->free[k]);
        of_echo[pairs->echoes[k]] += odds[k];
    }
    for (int64_t k = 0; k < pairs->count; k++) {
        const double after = 1.0 / larger(1.0, of_echo[pairs->echoes[k]] - odds[k]);
        change = larger(fabs(after - pairs->free[k]), change);
        pairs->free[k] = after;
    }
    return change;
}

/* Sets the probabilities of pairs of n objects and m echoes. */
static void find_shares(const Pairs *pairs, int64_t n, int64_t m)
{
    double *ratio = SCRATCH(double, pairs->count), *odds = SCRATCH(double, pairs->count);
    double *of_object = SCRATCH(double, n), *of_echo = SCRATCH(double, m), change = 1.0;
    for (int64_t k = 0; k < pairs->count; k++)
        ratio[k] = exp(smaller(pairs->score[k], MOST_RATIO));
    fill(pairs->free, pairs->count, 1.0);
    for (int64_t round = 0; change > CONVERGED && round < ROUNDS; round++)
        change = send_messages(pairs, ratio, odds, of_object, of_echo, n, m);
    add_up_worth(pairs, ratio, of_object, n);
    for (int64_t k = 0; k < pairs->count; k++)
        pairs->share[k] = ratio[k] * pairs->free[k] / of_object[pairs->objects[k]];
}

/* Fills in the probabilities of pairs, and those that a pair's echo is of no other object: see `jpda.shares`. */
KERNEL(jpda_shares, HYPOTHESES ", int n, int m, out f8[p] share, out f8[p] free")
{
    const Hypotheses given = hypotheses_from(arguments, 0);
    const int64_t n = INT(4), m = INT(5);
    const Pairs pairs = {given.objects,    given.echoes,     given.llr,  given.score,
                         ARRAY(double, 6), ARRAY(double, 7), given.count};
    fill(pairs.share, given.count, 0.0);
    fill(pairs.free, given.count, 0.0);
    for (int64_t k = 0; k < given.count; k++)
        if (!is_pair(&given, k, n, m))
            return;
    find_shares(&pairs, n, m);
}

/* Returns the noise variance of the middle of several measurements with which an update ends where all of them do.

   `seen`: sum of the probabilities of the measurements; `mean`, `square_sum`: sums of their innovations and of the
   squares by these weights; `variance`: of the prediction; `noise`: of a measurement. With S = variance + noise,
   probabilistic data association takes (variance / S)^2 (seen S - square_sum + mean^2) off the variance; so does an
   update with the noise returned. Its step is that of probabilistic data association, too, but smaller where
   innovations are spread: no single measurement at the middle gives both; where they would make the variance grow, the
   gain is the share `least_gain` of that of a sure echo. */
static double noise_of_all(double seen, double mean, double square_sum, double variance, double noise,
                           double least_gain)
{
    const double total = variance + noise;
    const double lowered = larger(least_gain * total, seen * total - larger(0.0, square_sum - square(mean)));
    return noise + total * (total / lowered - 1.0);
}

/* What is summed up for an object over its pairs: probabilities and likelihood ratios, and by probability the
   innovations of range, bearing and radius, their squares, and the variances of the noise. */
typedef struct {
    int64_t strongest; /* pair; -1: none */
    double seen, chance;
    double mean[3], square[3], noise[3];
} Sums;

/* n objects, as predicted. */
typedef struct {
    PredictedMeasurement predicted;
    const double *radius, *radius_variance;
    int64_t n;
} Objects;

static Sums *added_up(const Pairs *pairs, const Objects *objects, const EchoRows *echoes)
{
    Sums *sums = ZEROS(Sums, objects->n);
    for (int64_t i = 0; i < objects->n; i++)
        sums[i].strongest = -1;
    for (int64_t k = 0; k < pairs->count; k++) {
        const int64_t i = pairs->objects[k], j = pairs->echoes[k];
        Sums *sum = &sums[i];
        const double share = pairs->share[k];
        const double innovation[] = {echoes->range_m[j] - objects->predicted.range_m[i],
                                     wrapped(echoes->bearing[j] - objects->predicted.bearing[i]),
                                     echoes->radius[j] - objects->radius[i]};
        const double sigma[] = {echoes->sigma_range[j], echoes->sigma_bearing[j], echoes->sigma_radius[j]};
        if (sum->strongest < 0 || share > pairs->share[sum->strongest])
            sum->strongest = k;
        sum->seen += share;
        sum->chance += pairs->free[k] * exp(smaller(MOST_RATIO, pairs->llr[k]));
        for (int axis = 0; axis < 3; axis++) {
            sum->mean[axis] += share * innovation[axis];
            sum->square[axis] += share * square(innovation[axis]);
            sum->noise[axis] += share * square(sigma[axis]);
        }
    }
    return sums;
}

/* Sets range, bearing and radius of echo k `made` for object i, and how sure they are. */
static void set_middle(const EchoRows *made, int64_t k, const Objects *objects, int64_t i, const Sums *sum,
                       double least_gain)
{
    const PredictedMeasurement *predicted = &objects->predicted;
    const double middle[] = {predicted->range_m[i], predicted->bearing[i], objects->radius[i]};
    const double variance[] = {predicted->along[i], predicted->across[i] / square(predicted->horizontal[i]),
                               objects->radius_variance[i]};
    double *measured[] = {made->range_m, made->bearing, made->radius};
    double *sigmas[] = {made->sigma_range, made->sigma_bearing, made->sigma_radius};
    for (int axis = 0; axis < 3; axis++) {
        const double own = sum->noise[axis] / sum->seen;
        measured[axis][k] = middle[axis] + sum->mean[axis] / sum->seen;
        sigmas[axis][k] = sqrt(
            noise_of_all(sum->seen, sum->mean[axis], sum->square[axis], variance[axis], own, least_gain));
    }
}

/* Sets elevation, its reach and the cut of each echo `made`, for each object with a place in them, so that no rival is
   ruled out.

   One cut off that may be the object's own moves the middle by an error that stays, so the middle counts as cut off: to
   take a whole echo for one loses one image, to take a slide for noise makes a motion of it. Heights are from the
   lowest to the highest that any of the planes leaves open, where planes are distinguished. */
static void tell_what_holds_for_any(const EchoRows *made, const int64_t *place, const Pairs *pairs, const Sums *sums,
                                    const EchoRows *echoes)
{
    for (int64_t pair = 0; pair < pairs->count; pair++) {
        const int64_t i = pairs->objects[pair], j = pairs->echoes[pair], k = place[i];
        if (k < 0 || pairs->share[pair] < RIVAL * pairs->share[sums[i].strongest])
            continue;
        made->cut[k] = larger(echoes->cut[j], made->cut[k]);
        if (!(made->half_vertical[k] > 0.0))
            continue;
        const double own = made->half_vertical[k], other = echoes->half_vertical[j];
        const double lowest = smaller(echoes->elevation[j] - other, made->elevation[k] - own);
        const double highest = larger(echoes->elevation[j] + other, made->elevation[k] + own);
        made->elevation[k] = 0.5 * (lowest + highest);
        made->half_vertical[k] = 0.5 * (highest - lowest);
    }
}

/* Sets of k objects seen the most probable pair, its log-likelihood ratio and one echo each, (12, k) from `table` on,
   as far as there is room; returns k. */
static int64_t put_together(const Pairs *pairs, const Objects *objects, const EchoRows *echoes, double least_gain,
                            int64_t room, int64_t *best, double *llr, double *table)
{
    const Sums *sums = added_up(pairs, objects, echoes);
    int64_t *place = SCRATCH(int64_t, objects->n), *seen = SCRATCH(int64_t, objects->n), count = 0;
    for (int64_t i = 0; i < objects->n; i++) {
        place[i] = sums[i].seen > 0.5 && count < room ? count : -1;
        if (place[i] >= 0)
            seen[count++] = i;
    }
    const EchoRows made = echo_rows(table, count);
    for (int64_t k = 0; k < count; k++) {
        const int64_t i = seen[k], j = pairs->echoes[sums[i].strongest];
        best[k] = sums[i].strongest;
        llr[k] = log(sums[i].chance);
        made.elevation[k] = echoes->elevation[j], made.half_vertical[k] = echoes->half_vertical[j], made.cut[k] = 0.0;
        made.strength[k] = echoes->strength[j], made.onset[k] = echoes->onset[j], made.front[k] = echoes->front[j];
        set_middle(&made, k, objects, i, &sums[i], least_gain);
    }
    tell_what_holds_for_any(&made, place, pairs, sums, echoes);
    return count;
}

/* Returns the pairs of objects that share echoes, `first`, and (count,) their numbers among all. */
static Pairs shared_pairs(const Hypotheses *all, const bool *first, int64_t n, int64_t m, int64_t **numbers)
{
    int64_t *objects = SCRATCH(int64_t, all->count), *echoes = SCRATCH(int64_t, all->count), count = 0;
    double *llr = SCRATCH(double, all->count), *score = SCRATCH(double, all->count);
    *numbers = SCRATCH(int64_t, all->count);
    for (int64_t k = 0; k < all->count; k++) {
        if (!is_pair(all, k, n, m) || !first[all->objects[k]])
            continue;
        objects[count] = all->objects[k], echoes[count] = all->echoes[k];
        llr[count] = all->llr[k], score[count] = all->score[k];
        (*numbers)[count++] = k;
    }
    return (Pairs){objects, echoes, llr, score, SCRATCH(double, count), SCRATCH(double, count), count};
}

/* Shares echoes among the objects that choose `first`: see `jpda.probabilistic`.

   Fills in which echoes these explain, and of k objects seen the most probable pair, its log-likelihood ratio, and what
   stands for all its echoes, (12, k) from the first number on. From what is left it marks as chosen the pairs of the
   other objects that have no rival, and fills in those that have. counts: k, and how many these are. */
KERNEL(jpda_share_out, HYPOTHESES
       ", b1[n] first, f8[12,m] echo_table, f8[8,n] predicted, f8[n] radius, f8[n] radius_variance, "
       "float least_gain, out b1[m] explained, out i8[room] best, out f8[room] best_llr, out f8[12,room] made, "
       "out b1[p] chosen, out i8[p] disputed, out i8[2] counts")
{
    const Hypotheses all = hypotheses_from(arguments, 0);
    const int64_t n = SIZE(4, 0), m = SIZE(5, 1);
    const bool *first = ARRAY(const bool, 4);
    const EchoRows echoes = echo_rows(ARRAY(double, 5), m);
    const Objects objects = {predicted_rows(ARRAY(double, 6), n), ARRAY(const double, 7), ARRAY(const double, 8), n};
    bool *explained = ARRAY(bool, 10), *left = SCRATCH(bool, all.count), *chosen = ARRAY(bool, 14);
    int64_t *numbers, *best = ARRAY(int64_t, 11), *counts = ARRAY(int64_t, 16);
    const Pairs pairs = shared_pairs(&all, first, n, m, &numbers);
    find_shares(&pairs, n, m);
    double *of_echo = ZEROS(double, m);
    for (int64_t k = 0; k < pairs.count; k++)
        of_echo[pairs.echoes[k]] += pairs.share[k];
    for (int64_t j = 0; j < m; j++) /* an echo that is more likely of an object starts no new one */
        explained[j] = of_echo[j] > 0.5;
    for (int64_t k = 0; k < all.count; k++)
        left[k] = is_pair(&all, k, n, m) && !first[all.objects[k]] && !explained[all.echoes[k]];
    counts[0] = put_together(&pairs, &objects, &echoes, FLOAT(9), SIZE(11, 0), best, ARRAY(double, 12),
                             ARRAY(double, 13));
    for (int64_t k = 0; k < counts[0]; k++)
        best[k] = numbers[best[k]];
    memset(chosen, 0, (size_t)all.count * sizeof *chosen);
    counts[1] = choose_undisputed(&all, left, n, m, chosen, ARRAY(int64_t, 15));
}

/* Fills in the assignment: the pairs `best` with their own ratios and echoes `made`, (12, k) from the first number on,
   and then those `chosen`; and which echoes these explain. k: as many as `total` leaves to the former. */
KERNEL(jpda_assignment, HYPOTHESES
       ", f8[12,m] echo_table, i8[room] best, f8[room] best_llr, f8[12,room] made, b1[p] chosen, "
       "out b1[m] explained, out i8[total] objects, out i8[total] echoes, out f8[total] llr, out f8[total] score, "
       "out f8[12,total] table")
{
    const Hypotheses all = hypotheses_from(arguments, 0);
    const double *echo_table = ARRAY(const double, 4), *own_llr = ARRAY(const double, 6),
                 *made = ARRAY(const double, 7);
    const int64_t m = SIZE(4, 1), total = SIZE(10, 0), *best = ARRAY(const int64_t, 5);
    const bool *chosen = ARRAY(const bool, 8);
    bool *explained = ARRAY(bool, 9);
    int64_t *objects = ARRAY(int64_t, 10), *echoes = ARRAY(int64_t, 11), *pairs = SCRATCH(int64_t, total), others = 0;
    double *llr = ARRAY(double, 12), *score = ARRAY(double, 13), *table = ARRAY(double, 14);
    for (int64_t k = 0; k < all.count; k++)
        others += chosen[k];
    const int64_t seen = total - others;
    if (seen < 0 || seen > SIZE(5, 0))
        return;
    for (int64_t k = 0, place = seen; k < all.count; k++)
        if (chosen[k])
            pairs[place++] = k;
    memcpy(pairs, best, (size_t)seen * sizeof *pairs);
    for (int64_t place = 0; place < total; place++) {
        const int64_t k = pairs[place], j = echoes[place] = all.echoes[k];
        objects[place] = all.objects[k], score[place] = all.score[k];
        llr[place] = place < seen ? own_llr[place] : all.llr[k];
        explained[j] |= place >= seen;
        for (int64_t row = 0; row < SIZE(4, 0); row++)
            table[row * total + place] = place < seen ? made[row * seen + place] : echo_table[row * m + j];
    }
}
