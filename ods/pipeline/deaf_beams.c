/* Beams that say nothing of the water: saturated ones, and such as hear a source that sounds without end. See
   deaf_beams.py. */

#include "ods/pipeline/image/no_data.h"
#include "ods/pipeline/image/samples.h"

/* Parts of the range, */
#define RINGS 16
/* samples in a row that are looked at of each, */
#define LOOKED_AT 8
/* and rings of which nothing is required, as bodies and their shadows may be there. */
#define LEFT_OUT 2
/* A beam is saturated where this share of the samples is at full scale in three quarters of its rings, until it is in
   fewer than a quarter. */
#define SATURATED_SHARE 0.125f
#define SATURATED_RINGS (3 * RINGS / 4)
#define STILL_RINGS (RINGS / 4)
/* A beam is raised when it is so far over its gain, dB, until it is less than so far over it. */
#define RAISED_DB 6.0f
#define LOWERED_DB 4.0f
/* While its gain is not known: what no gain is, dB; or so much more than its excess in the loudest rings in the
   quietest ones, of each a quarter, as what is added makes it, but no gain. */
#define NO_GAIN_DB 24.0f
#define ADDED_DB 6.0f
#define QUARTER (RINGS / 4)
/* Beams beside a raised one are filled by its side lobes when so far over their gain in the quietest rings, dB, until
   they are less than so far over it. */
#define FILLED_DB 3.0f
#define EMPTIED_DB 1.5f
/* If more than one in so many beams are raised it is the scene that is loud there: a source is heard in few. */
#define FEW 4
/* Fewer beams have no level in common. */
#define FEWEST_BEAMS 8
/* Time constants of a beam's gain: while it is not raised, and while it is. */
#define LEARNING_S 10.0
#define FORGETTING_S 600.0
/* Steps of the search for a median: it is known to a 2000th of the spread. */
#define HALVINGS 11

enum { HEARS = 0, SATURATED = 2, DROWNED = 4 };

/* Levels of the parts of one plane's beams, dB; (RINGS, beams) each, NaN where nothing is known. */
typedef struct {
    int64_t beams;
    float *excess;  /* over the beams' median */
    float *gain;    /* what that was */
    float middle[RINGS];
    uint8_t *codes; /* (beams,) */
} Plane;

/* What samples mean. */
typedef struct {
    float top;        /* full scale */
    float db_a_count; /* what a count is worth where counts are logarithms; 0 where they are not */
    float offset;     /* of a linear count */
} Meaning;

/* Returns 20 log10 of an amplitude, 0.06 dB off at most. */
static float db_of(float amplitude)
{
    union {
        float value;
        uint32_t bits;
    } x = {amplitude};
    const float exponent = (float)(int32_t)(x.bits >> 23) - 128.0f;
    x.bits = (x.bits & 0x7FFFFFu) | 0x3F800000u;
    return 6.0206f * (exponent + (-0.33582878f * x.value + 2.0f) * x.value - 0.65871759f);
}

/* What is looked at of a part. */
typedef struct {
    float total;
    int32_t count, full;
} Seen;

static Seen look(Samples frame, Missing missing, int64_t beam, int64_t begin, float top)
{
    Seen seen = {0.0f, LOOKED_AT, 0};
    float values[LOOKED_AT];
    load_samples(frame, beam, begin, 1, LOOKED_AT, values);
    if (missing.marks != NULL)
        for (int64_t k = 0; k < LOOKED_AT; k++)
            if (is_missing(missing, beam, begin + k)) {
                values[k] = 0.0f;
                seen.count--;
            }
    for (int64_t k = 0; k < LOOKED_AT; k++) {
        seen.total += values[k];
        seen.full += values[k] >= top;
    }
    return seen;
}

static float level_of(Seen seen, Meaning meaning)
{
    const float mean = seen.total / (float)seen.count;
    if (2 * seen.count < LOOKED_AT)
        return NAN;
    if (meaning.db_a_count > 0.0f)
        return mean * meaning.db_a_count;
    return mean + meaning.offset > 1e-12f ? db_of(mean + meaning.offset) : NAN;
}

/* Fills the plane's excess with levels, (RINGS, beams), and notes the beams that are saturated. */
static void measure_levels(Samples frame, int64_t row, int64_t first, Missing missing, Meaning meaning, Plane plane)
{
    const int64_t samples = frame.samples - first;
    for (int64_t b = 0; b < plane.beams; b++) {
        int32_t full_rings = 0;
        for (int64_t r = 0; r < RINGS; r++) {
            const int64_t begin = first + (2 * r + 1) * samples / (2 * RINGS) - LOOKED_AT / 2;
            const Seen seen = look(frame, missing, row + b, begin, meaning.top);
            plane.excess[r * plane.beams + b] = level_of(seen, meaning);
            full_rings += (float)seen.full >= SATURATED_SHARE * LOOKED_AT;
        }
        const bool was = plane.codes[b] == SATURATED, is = full_rings >= (was ? STILL_RINGS : SATURATED_RINGS);
        plane.codes[b] = is ? SATURATED : was ? HEARS : plane.codes[b];
    }
}

/* Returns the median of those levels of a ring that are known and of beams that are not saturated; NaN: too few. */
static float median_level(const float *level, const uint8_t *codes, int64_t beams, float *kept)
{
    int32_t count = 0;
    float low = INFINITY, high = -INFINITY;
    for (int64_t b = 0; b < beams; b++)
        if (codes[b] != SATURATED && !isnan(level[b])) {
            kept[count++] = level[b];
            low = smaller_f(level[b], low);
            high = larger_f(level[b], high);
        }
    if (count < FEWEST_BEAMS)
        return NAN;
    for (int64_t step = 0; step < HALVINGS; step++) {
        const float at = 0.5f * (low + high);
        int32_t above = 0;
        for (int32_t i = 0; i < count; i++)
            above += kept[i] > at;
        if (2 * above >= count)
            low = at;
        else
            high = at;
    }
    return 0.5f * (low + high);
}

/* Turns the plane's levels into excesses. */
static void compare(Plane *plane)
{
    float *kept = SCRATCH(float, plane->beams);
    for (int64_t r = 0; r < RINGS; r++) {
        float *row = plane->excess + r * plane->beams;
        plane->middle[r] = median_level(row, plane->codes, plane->beams, kept);
        for (int64_t b = 0; b < plane->beams; b++)
            row[b] -= plane->middle[r];
    }
}

/* Fills order with the rings that are known, the quietest first; returns how many there are. */
static int64_t by_level(const float *middle, int64_t *order)
{
    int64_t count = 0;
    for (int64_t r = 0; r < RINGS; r++) {
        if (isnan(middle[r]))
            continue;
        int64_t k = count++;
        for (; k > 0 && middle[order[k - 1]] > middle[r]; k--)
            order[k] = order[k - 1];
        order[k] = r;
    }
    return count;
}

/* Returns the mean excess of a beam in `count` rings; over its gain where that is known and wanted. */
static float mean_excess(Plane plane, int64_t beam, const int64_t *rings, int64_t count, bool over_gain)
{
    float total = 0.0f;
    for (int64_t k = 0; k < count; k++) {
        const int64_t cell = rings[k] * plane.beams + beam;
        const float gain = plane.gain[cell];
        total += plane.excess[cell] - (over_gain && !isnan(gain) ? gain : 0.0f);
    }
    return total / (float)count;
}

/* Whether a beam is louder over all of its range than its gain makes it. */
static bool is_raised(Plane plane, int64_t beam, const int64_t *order, int64_t rings)
{
    const float limit = plane.codes[beam] == DROWNED ? LOWERED_DB : RAISED_DB;
    int32_t known = 0, over_gain = 0, over_all = 0, far_over_all = 0;
    for (int64_t r = 0; r < RINGS; r++) {
        const float excess = plane.excess[r * plane.beams + beam], gain = plane.gain[r * plane.beams + beam];
        known += !isnan(excess);
        over_gain += excess - gain >= limit;
        over_all += excess >= limit;
        far_over_all += excess >= NO_GAIN_DB;
    }
    const int32_t enough = known - LEFT_OUT;
    if (2 * known < RINGS || (over_gain < enough && over_all < enough))
        return false;
    if (over_gain >= enough || far_over_all >= enough)
        return true;
    const float quiet = mean_excess(plane, beam, order, QUARTER, false);
    return quiet - mean_excess(plane, beam, order + rings - QUARTER, QUARTER, false) >= ADDED_DB;
}

/* Notes the beams from one beside a raised one on, in steps, that are filled by its side lobes. */
static void fill_beside(Plane plane, int64_t raised, int64_t step, const int64_t *order, uint8_t *codes)
{
    for (int64_t b = raised + step; b >= 0 && b < plane.beams && codes[b] == HEARS; b += step) {
        const float limit = plane.codes[b] == DROWNED ? EMPTIED_DB : FILLED_DB;
        if (!(mean_excess(plane, b, order, QUARTER, true) >= limit))
            return;
        codes[b] = DROWNED;
    }
}

/* Judges which beams of a plane are drowned by a source. */
static void find_drowned(Plane plane)
{
    int64_t order[RINGS], raised = 0;
    const int64_t rings = by_level(plane.middle, order);
    uint8_t *codes = ZEROS(uint8_t, plane.beams);
    for (int64_t b = 0; b < plane.beams && 2 * rings >= RINGS; b++) {
        const bool deaf = plane.codes[b] != SATURATED && is_raised(plane, b, order, rings);
        codes[b] = deaf ? DROWNED : plane.codes[b] == SATURATED ? SATURATED : HEARS;
        raised += deaf;
    }
    const bool is_source = raised > 0 && FEW * raised <= plane.beams;
    uint8_t *seeds = SCRATCH(uint8_t, plane.beams);
    memcpy(seeds, codes, (size_t)plane.beams);
    for (int64_t b = 0; b < plane.beams && is_source; b++)
        if (seeds[b] == DROWNED) {
            fill_beside(plane, b, 1, order, codes);
            fill_beside(plane, b, -1, order, codes);
        }
    for (int64_t b = 0; b < plane.beams; b++)
        if (plane.codes[b] != SATURATED)
            plane.codes[b] = is_source ? codes[b] : HEARS;
}

/* Lets the gains of a plane's beams follow. */
static void follow_gains(Plane plane, double since_s)
{
    const float learning = (float)-expm1(-since_s / LEARNING_S), forgetting = (float)-expm1(-since_s / FORGETTING_S);
    for (int64_t r = 0; r < RINGS; r++)
        for (int64_t b = 0; b < plane.beams; b++) {
            const float excess = plane.excess[r * plane.beams + b];
            float *gain = plane.gain + r * plane.beams + b;
            if (isnan(excess) || plane.codes[b] == SATURATED)
                continue;
            if (isnan(*gain))
                *gain = plane.codes[b] == DROWNED ? 0.0f : excess;
            else
                *gain += (plane.codes[b] == DROWNED ? forgetting : learning) * (excess - *gain);
        }
}

/* Judges the beams of a frame from column `first` on, plane by plane; tells whether any is deaf.
   gain (planes, rings, beams of a plane): of the beams in the parts of their range, dB; codes (beams,): as in
   deaf_beams.py, those of the ping before; both follow. */
KERNEL_BOOL(judge_beams, "rows u1|u2|f4[beams,:] frame, int first, " MISSING ", float top, float db_a_count, float offset, "
                         "float since_s, out f4[planes,16,per_plane] gain, out u1[beams] codes")
{
    const int64_t first = INT(1), planes = SIZE(7, 0), per_plane = SIZE(7, 2);
    const Missing missing = missing_at(&arguments[2], SIZE(0, 0), SIZE(0, 1));
    const Meaning meaning = {(float)FLOAT(3), (float)FLOAT(4), (float)FLOAT(5)};
    uint8_t *codes = ARRAY(uint8_t, 8);
    bool any = false;
    if (first < 0 || SIZE(0, 1) - first < RINGS * LOOKED_AT || planes * per_plane != SIZE(0, 0))
        return false;
    for (int64_t p = 0; p < planes; p++) {
        Plane plane = {per_plane, SCRATCH(float, RINGS * per_plane), ARRAY(float, 7) + p * RINGS * per_plane, {0.0f},
                       codes + p * per_plane};
        measure_levels(SAMPLES(0), p * per_plane, first, missing, meaning, plane);
        compare(&plane);
        find_drowned(plane);
        follow_gains(plane, FLOAT(6));
    }
    for (int64_t b = 0; b < SIZE(0, 0); b++)
        any |= codes[b] != HEARS;
    return any;
}
