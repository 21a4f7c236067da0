/* Levels of parts of a ping's samples, and what they were: see sight.py. */

#include "ods/pipeline/image/missing/fill.h"
#include "ods/pipeline/image/samples/samples.h"

/* Samples of each part that are looked at. */
#define LOOKED_AT 4
/* A level is fallen when it is so far below what it was, until it is less than so far below it, */
#define FALLEN_DB 12.0
#define RISEN_DB 9.0
/* and a group of beams is blind when so many of its ranges are fallen. */
#define FALLEN_SHARE 0.75
/* What was learnt may differ so much from what is usual by chance: few samples are looked at. */
#define CHANCE_DB (FALLEN_DB - RISEN_DB)
/* Stands for the level of no count at all, dB over one count. */
#define LEAST_DB -26.0
/* A part of which some samples are 0 and the others at least so many counts, or so loud, has no level that could fall:
   the sonar reports only what passes a threshold. */
#define STEP 2.0
#define STEP_DB 18.0

/* Parts of beams and range, (groups, rings). */
typedef struct {
    int64_t groups, rings;
    double *now_db;    /* NaN where nothing holds data, or no level is reported */
    double *was_db;    /* NaN where not known */
    double *usual_db;  /* the lower of that and of what it was before it rose */
    double *saturated; /* share of the samples */
} Levels;

#define LEVELS "out f8[groups,rings] now_db, out f8[groups,rings] was_db, " \
               "out f8[groups,rings] usual_db, out f8[groups,rings] saturated"

/* Fills values (groups, rings, LOOKED_AT) with samples from column `first` on; NaN where one holds no data. */
static void look_at_parts(Samples frame, int64_t first, Missing missing, Levels levels, float *values)
{
    const int64_t beams = missing.beams, samples = missing.samples - first;
    int64_t *column = SCRATCH(int64_t, levels.rings * LOOKED_AT);
    for (int64_t r = 0; r < levels.rings; r++) {
        const int64_t begin = first + r * samples / levels.rings, stop = first + (r + 1) * samples / levels.rings;
        for (int64_t k = 0; k < LOOKED_AT; k++)
            column[r * LOOKED_AT + k] =
                smaller_i(begin + (2 * k + 1) * (stop - begin) / (2 * LOOKED_AT), missing.samples - 1);
    }
    for (int64_t g = 0; g < levels.groups; g++) {
        const int64_t low = g * beams / levels.groups, high = larger_i((g + 1) * beams / levels.groups, low + 1);
        for (int64_t k = 0; k < LOOKED_AT; k++) {
            const int64_t b = smaller_i(low + k * (high - low) / LOOKED_AT, beams - 1);
            for (int64_t i = k; i < levels.rings * LOOKED_AT; i += LOOKED_AT) {
                load_samples(frame, b, column[i], 1, 1, values + i);
                if (is_missing(missing, b, column[i]))
                    values[i] = NAN;
            }
        }
        values += levels.rings * LOOKED_AT;
    }
}

/* What is looked at of a part. */
typedef struct {
    double total, least;
    int32_t count, zeros, saturated;
} Seen;

static Seen seen_of(const float *values, double top)
{
    Seen seen = {0.0, INFINITY, 0, 0, 0};
    for (int64_t k = 0; k < LOOKED_AT; k++) {
        const bool holds = !isnan(values[k]), loud = values[k] != 0.0f;
        seen.total += holds ? values[k] : 0.0;
        seen.count += holds;
        seen.zeros += holds && !loud;
        seen.saturated += values[k] >= top;
        seen.least = smaller(holds && loud ? values[k] : INFINITY, seen.least);
    }
    return seen;
}

static double level_of(Seen seen, Meaning meaning)
{
    const double step = meaning.db_a_count > 0.0 ? STEP_DB / meaning.db_a_count : STEP;
    const double mean = seen.total / (double)seen.count;
    if (seen.count == 0 || (seen.zeros > 0 && seen.zeros < seen.count && seen.least >= step))
        return NAN;
    return meaning.db_a_count > 0.0 ? mean * meaning.db_a_count : larger(20.0 * log10(mean), LEAST_DB);
}

/* Fills now_db and saturated of the levels from some samples of each part. */
static void measure(Samples frame, int64_t first, Missing missing, Meaning meaning, Levels levels)
{
    const int64_t parts = levels.groups * levels.rings;
    float *values = SCRATCH(float, parts * LOOKED_AT);
    look_at_parts(frame, first, missing, levels, values);
    for (int64_t k = 0; k < parts; k++) {
        const Seen seen = seen_of(values + k * LOOKED_AT, meaning.top);
        levels.saturated[k] = (double)seen.saturated / LOOKED_AT;
        levels.now_db[k] = level_of(seen, meaning);
    }
}

/* Whether a group of beams is blind, from ring `from` on; least_db: levels that were lower are not judged. */
static bool is_fallen(Levels levels, int64_t from, double least_db, bool was_fallen)
{
    const double limit = was_fallen ? RISEN_DB : FALLEN_DB;
    int64_t known = 0, low = 0;
    for (int64_t r = from; r < from + levels.rings; r++) {
        const double before_db = smaller(levels.was_db[r], levels.usual_db[r] + CHANCE_DB);
        if (isfinite(levels.now_db[r]) && before_db >= least_db) {
            known++;
            low += before_db - levels.now_db[r] >= limit;
        }
    }
    return known >= levels.rings / 4 ? (double)low >= FALLEN_SHARE * (double)known : was_fallen;
}

/* Whether a group of beams is drowned, from ring `from` on, where it was not, by the levels of the ping before, last_db,
   or still is: levels over nearly all ranges jumped, those nearest to the sonar too, as noise does. A bottom that comes
   into view rises more slowly, and not right before the sonar. */
static bool is_risen(Levels levels, const double *last_db, int64_t from, bool was_risen)
{
    int64_t known = 0, high = 0;
    const double nearest_db = levels.now_db[from] - larger(last_db[from], levels.was_db[from]);
    const bool nearest = was_risen || nearest_db >= 0.5 * FALLEN_DB; /* whose few samples vary */
    for (int64_t r = from; r < from + levels.rings; r++) {
        const double before_db = was_risen ? levels.was_db[r] : larger(last_db[r], levels.was_db[r]);
        if (isfinite(levels.now_db[r]) && isfinite(before_db)) {
            known++;
            high += levels.now_db[r] - before_db >= (was_risen ? RISEN_DB : FALLEN_DB);
        }
    }
    return known >= levels.rings / 4 ? nearest && (double)high >= FALLEN_SHARE * (double)known : was_risen;
}

/* By what share what the level was follows: while the beams see, while they are blind, and while they are drowned. What
   is usual rises as slowly as while they are blind: a loud spell of minutes is none. */
typedef struct {
    double fast, slow, growing;
} Rates;

/* Judges the groups' levels, fallen and risen (groups,), and lets what they were follow; returns whether anything is unseen.
   last_db: of the ping before; least_db: levels that were lower are not judged; most_saturated: share of a part that is unseen. */
static bool follow(Levels levels, const double *last_db, double least_db, double most_saturated, Rates rates, bool *fallen,
                   bool *risen)
{
    bool blind = false;
    for (int64_t g = 0; g < levels.groups; g++) {
        const double *now_db = levels.now_db + g * levels.rings, *saturated = levels.saturated + g * levels.rings;
        double *was_db = levels.was_db + g * levels.rings, *usual_db = levels.usual_db + g * levels.rings;
        fallen[g] = is_fallen(levels, g * levels.rings, least_db, fallen[g]);
        risen[g] = is_risen(levels, last_db, g * levels.rings, risen[g]);
        blind |= fallen[g] || risen[g];
        const double learning = fallen[g] ? rates.slow : risen[g] ? rates.growing : rates.fast;
        for (int64_t r = 0; r < levels.rings; r++) {
            blind |= saturated[r] > most_saturated;
            if (!isfinite(now_db[r]))
                continue;
            was_db[r] = isfinite(was_db[r]) ? was_db[r] + learning * (now_db[r] - was_db[r]) : now_db[r];
            usual_db[r] = isfinite(usual_db[r]) ? smaller(usual_db[r] + rates.slow * (was_db[r] - usual_db[r]), was_db[r]) : was_db[r];
        }
    }
    return blind;
}

/* Returns the lowest level that can fall far enough to be noticed, of what the samples' mean can represent. */
static double least_judged_db(char type, Meaning meaning)
{
    if (type == 'f')
        return -INFINITY;
    return (meaning.db_a_count > 0.0 ? 0.0 : LEAST_DB) + FALLEN_DB + CHANCE_DB;
}

/* Measures the levels of a frame from column `first` on and judges them; returns whether anything is unseen. */
KERNEL_BOOL(judge_levels, "rows u1|u2|f4[beams,:] frame, int first, " MISSING ", " MEANING ", " LEVELS
                          ", float most_saturated, float since_s, float learning_s, float forgetting_s, float growing_used_s, "
                          "out b1[groups] fallen, out b1[groups] risen")
{
    const Missing missing = missing_at(&arguments[2], SIZE(0, 0), SIZE(0, 1));
    const Meaning meaning = MEANING_AT(3);
    const Levels levels = {SIZE(5, 0), SIZE(5, 1), ARRAY(double, 5), ARRAY(double, 6), ARRAY(double, 7),
                           ARRAY(double, 8)};
    const double since_s = FLOAT(10);
    const Rates rates = {-expm1(-since_s / FLOAT(11)), -expm1(-since_s / FLOAT(12)), -expm1(-since_s / FLOAT(13))};
    if (SIZE(0, 0) == 0 || INT(1) < 0 || INT(1) >= SIZE(0, 1))
        return false;
    double *last_db = SCRATCH(double, levels.groups * levels.rings);
    memcpy(last_db, levels.now_db, (size_t)(levels.groups * levels.rings) * sizeof *last_db);
    measure(SAMPLES(0), INT(1), missing, meaning, levels);
    return follow(levels, last_db, least_judged_db(TYPE(0), meaning), FLOAT(9), rates, ARRAY(bool, 14), ARRAY(bool, 15));
}

/* Fills shares with what is missing of each ring from column `first` on, but for gaps that are bridged. */
KERNEL(shares_of_gaps, "b1[beams,samples] missing, int first, out f8[beams,rings] shares")
{
    const int64_t first = larger_i(INT(1), 0), samples = SIZE(0, 1) - first, rings = SIZE(2, 1);
    for (int64_t b = 0; b < SIZE(0, 0) && samples > 0; b++) {
        const bool *gaps = ARRAY(const bool, 0) + b * SIZE(0, 1) + first;
        double *shares = ARRAY(double, 2) + b * rings;
        memset(shares, 0, (size_t)rings * sizeof *shares);
        for (Span gap = next_gap(gaps, 0, samples); gap.begin < samples; gap = next_gap(gaps, gap.stop, samples))
            for (int64_t j = gap.begin; j < gap.stop && !is_bridged(gap); j++)
                shares[j * rings / samples] += 1.0;
        for (int64_t r = 0; r < rings; r++)
            shares[r] /= (double)larger_i((r + 1) * samples / rings - r * samples / rings, 1);
    }
}
