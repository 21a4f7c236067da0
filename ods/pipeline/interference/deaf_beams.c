/* Beams that say nothing of the water: saturated ones, and such as receive a source that sounds without end. See
   deaf_beams.py. */

#include "ods/pipeline/filter/rows/halving.h"
#include "ods/pipeline/filter/rows/lanes.h"
#include "ods/pipeline/image/missing/no_data.h"
#include "ods/pipeline/image/samples/decibels.h"
#include "ods/pipeline/image/samples/samples.h"

/* Samples in a row that are looked at of each part of the range, */
#define LOOKED_AT LANES
/* and rings of which nothing is required, as bodies and their shadows may be there. */
#define LEFT_OUT 2
/* A beam is raised when it is so far over its gain, dB, until it is less than so far over it. */
#define RAISED_DB 6.0f
#define LOWERED_DB 4.0f
/* While its gain is not known: what no gain is, dB. Or its excess in the quietest quarter of the rings is by RAISED_DB
   more than in the loudest, as what is added makes it, but no gain. */
#define NO_GAIN_DB 24.0f
/* If more than one in so many beams are raised it is the scene that is loud there: a source is received in few. */
#define FEW 4
/* Beams as far as an eighth of them to either side of the loudest of a source hear this much less of it, dB. Where a
   vehicle rolls, many are raised, the more the farther they are to one side. */
#define BESIDE 8
#define STANDS_OUT_DB 4.0f
/* Beams whose samples are fetched before their turn. */
#define AHEAD 2

enum { HEARS = 0, SATURATED = 2, DROWNED = 4 };

/* Levels of the parts of one plane's beams, dB; (rings, beams) each, NaN where nothing is known. */
typedef struct {
    int64_t beams, rings;
    float *excess;  /* over the beams' median */
    float *gain;    /* what that was */
    float *middle;  /* (rings,) */
    uint8_t *codes; /* (beams,) */
} Plane;

/* Returns the samples of a beam from `begin` on. */
static inline Lanes lanes_of(Samples frame, int64_t beam, int64_t begin)
{
    typedef uint8_t Bytes __attribute__((vector_size(LANES), aligned(1), may_alias));
    typedef uint16_t Words __attribute__((vector_size(2 * LANES), aligned(2), may_alias));
    const char *from = frame.data + beam * frame.row_bytes + begin * sample_bytes(frame.type);
    switch (frame.type) {
    case 'B':
        return __builtin_convertvector(__builtin_convertvector(*(const Bytes *)from, Bits), Lanes);
    case 'H':
        return __builtin_convertvector(__builtin_convertvector(*(const Words *)from, Bits), Lanes);
    default:
        return load((const float *)from);
    }
}

/* Fills total and count with the sum of the samples that are looked at of a part and hold data, and how many they are;
   returns the highest. */
static float look(Samples frame, Missing missing, int64_t beam, int64_t begin, float *total, float *count)
{
    Lanes lanes = lanes_of(frame, beam, begin);
    int32_t held = LOOKED_AT;
    for (int64_t k = 0; k < LOOKED_AT && missing.marks != NULL; k++)
        if (is_missing(missing, beam, begin + k)) {
            lanes[k] = 0.0f;
            held--;
        }
    *total = sum_of_lanes(lanes), *count = (float)held;
    return highest_lane(lanes);
}

/* Turns sums of samples into levels, dB; NaN where too few hold data or there is no level. */
static void turn_into_levels(float *sums, const float *counts, int64_t size, Meaning meaning, float offset)
{
    const float db_a_count = (float)meaning.db_a_count;
    for (int64_t k = 0; k < size; k++) {
        const float mean = sums[k] / larger_f(counts[k], 1.0f);
        const float amplitude = mean + offset, by_count = mean * db_a_count;
        const float level = db_a_count > 0.0f ? by_count : amplitude > 1e-12f ? decibels(amplitude) : NAN;
        sums[k] = 2.0f * counts[k] < LOOKED_AT ? NAN : level;
    }
}

/* Asks for what is looked at of a beam: the cache cannot foresee that. begin (rings,): first columns. */
static void fetch(Samples frame, int64_t beam, const int64_t *begin, int64_t rings)
{
    for (int64_t r = 0; r < rings; r++)
        __builtin_prefetch(frame.data + beam * frame.row_bytes + begin[r] * sample_bytes(frame.type));
}

/* Fills the plane's excess with levels, (rings, beams), and notes the beams that are saturated: where one of the samples
   is at full scale in three quarters of its rings, until it is in fewer than a quarter. */
static void measure_levels(Samples frame, int64_t row, int64_t first, Missing missing, Meaning meaning, Plane plane)
{
    const int64_t samples = frame.samples - first, rings = plane.rings;
    float *counts = SCRATCH(float, rings * plane.beams);
    int64_t *begin = SCRATCH(int64_t, rings);
    for (int64_t r = 0; r < rings; r++)
        begin[r] = first + (2 * r + 1) * samples / (2 * rings) - LOOKED_AT / 2;
    for (int64_t b = 0; b < plane.beams; b++) {
        int64_t full_rings = 0;
        fetch(frame, row + smaller_i(b + AHEAD, plane.beams - 1), begin, rings);
        for (int64_t r = 0; r < rings; r++) {
            const int64_t cell = r * plane.beams + b;
            const float highest = look(frame, missing, row + b, begin[r], &plane.excess[cell], &counts[cell]);
            full_rings += highest >= (float)meaning.top;
        }
        const bool was = plane.codes[b] == SATURATED, is = 4 * full_rings >= (was ? rings : 3 * rings);
        plane.codes[b] = is ? SATURATED : was ? HEARS : plane.codes[b];
    }
    const bool are_linear_counts = frame.type != 'f' && meaning.db_a_count == 0.0;
    turn_into_levels(plane.excess, counts, rings * plane.beams, meaning, are_linear_counts ? 0.5f : 0.0f);
}

/* Fills low and high with the borders of values; lanes, so that it vectorises. */
static void find_borders(const float *values, int32_t count, float *low, float *high)
{
    float lows[LANES], highs[LANES];
    int32_t k = 0;
    for (int32_t l = 0; l < LANES; l++)
        lows[l] = INFINITY, highs[l] = -INFINITY;
    for (; k + LANES <= count; k += LANES)
        for (int32_t l = 0; l < LANES; l++) {
            lows[l] = values[k + l] < lows[l] ? values[k + l] : lows[l];
            highs[l] = values[k + l] > highs[l] ? values[k + l] : highs[l];
        }
    for (int32_t l = 0; k < count; k++, l++)
        lows[l] = smaller_f(values[k], lows[l]), highs[l] = larger_f(values[k], highs[l]);
    *low = lows[0], *high = highs[0];
    for (int32_t l = 1; l < LANES; l++)
        *low = smaller_f(*low, lows[l]), *high = larger_f(*high, highs[l]);
}

/* Returns the median of those levels of a ring that are known and of beams that are not saturated; NaN: too few. */
static float median_level(const float *level, const uint8_t *codes, int64_t beams, float *kept)
{
    int32_t count = 0;
    float low, high;
    for (int64_t b = 0; b < beams; b++) {
        kept[count] = level[b]; /* the next one takes the place of what does not count */
        count += codes[b] != SATURATED && !isnan(level[b]);
    }
    if (count < BESIDE)
        return NAN; /* so few have no level in common */
    find_borders(kept, count, &low, &high);
    return median_between(low, high, kept, count);
}

/* Turns the plane's levels into excesses. */
static void compare(Plane *plane)
{
    float *kept = SCRATCH(float, plane->beams);
    for (int64_t r = 0; r < plane->rings; r++) {
        float *row = plane->excess + r * plane->beams;
        plane->middle[r] = median_level(row, plane->codes, plane->beams, kept);
        for (int64_t b = 0; b < plane->beams; b++)
            row[b] -= plane->middle[r];
    }
}

/* Fills order with the rings that are known, the quietest first; returns how many there are. */
static int64_t by_level(const float *middle, int64_t rings, int64_t *order)
{
    int64_t count = 0;
    for (int64_t r = 0; r < rings; r++) {
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

/* In how many rings beams are known, and over their limit beside their gain, over it beside all, and far over it. */
typedef struct {
    int32_t *known, *over_gain, *over_all, *far_over_all; /* (beams,) */
} Rings;

static Rings count_rings(Plane plane)
{
    const int64_t beams = plane.beams;
    int32_t *restrict known = ZEROS(int32_t, beams), *restrict over_gain = ZEROS(int32_t, beams);
    int32_t *restrict over_all = ZEROS(int32_t, beams), *restrict far_over_all = ZEROS(int32_t, beams);
    float *restrict limit = SCRATCH(float, beams);
    for (int64_t b = 0; b < beams; b++)
        limit[b] = plane.codes[b] == DROWNED ? LOWERED_DB : RAISED_DB;
    for (int64_t r = 0; r < plane.rings; r++) {
        const float *restrict excess = plane.excess + r * beams, *restrict gain = plane.gain + r * beams;
        for (int64_t b = 0; b < beams; b++) {
            known[b] += excess[b] == excess[b];
            over_gain[b] += excess[b] - gain[b] >= limit[b];
            over_all[b] += excess[b] >= limit[b];
            far_over_all[b] += excess[b] >= NO_GAIN_DB;
        }
    }
    return (Rings){known, over_gain, over_all, far_over_all};
}

/* Whether a beam is louder over all of its range than its gain makes it. */
static bool is_raised(Plane plane, Rings counted, int64_t beam, const int64_t *order, int64_t rings)
{
    const int32_t known = counted.known[beam], enough = known - LEFT_OUT;
    if (2 * known < plane.rings || (counted.over_gain[beam] < enough && counted.over_all[beam] < enough))
        return false;
    if (counted.over_gain[beam] >= enough || counted.far_over_all[beam] >= enough)
        return true;
    const int64_t quarter = plane.rings / 4;
    const float quiet = mean_excess(plane, beam, order, quarter, false);
    return quiet - mean_excess(plane, beam, order + rings - quarter, quarter, false) >= RAISED_DB;
}

/* Returns by how much more than another beam one is over its gain, dB, in the mean of the rings. */
static float more_than(Plane plane, int64_t beam, int64_t other)
{
    float total = 0.0f;
    int32_t count = 0;
    for (int64_t r = 0; r < plane.rings; r++) {
        const float *excess = plane.excess + r * plane.beams, *gain = plane.gain + r * plane.beams;
        const float more = excess[beam] - excess[other], gains = gain[beam] - gain[other];
        if (isnan(more))
            continue;
        total += more - (isnan(gains) ? 0.0f : gains);
        count++;
    }
    return total / (float)count;
}

/* Whether a raised beam is so more than those to either side; near the fan's edge, by as much as on both
   sides together more than those to one side lead one to expect. */
static bool stands_out(Plane plane, int64_t beam)
{
    const int64_t aside = larger_i(plane.beams / BESIDE, 2);
    const bool port = beam - aside >= 0, starboard = beam + aside < plane.beams;
    if (port && starboard)
        return smaller_f(more_than(plane, beam, beam - aside), more_than(plane, beam, beam + aside)) >= STANDS_OUT_DB;
    const int64_t near = port ? beam - aside : beam + aside, far = port ? near - aside : near + aside;
    return more_than(plane, beam, near) - larger_f(more_than(plane, near, far), 0.0f) >= 2.0f * STANDS_OUT_DB;
}

/* Notes the beams from one beside a raised one on, in steps, that are filled by its side lobes: half as far over their
   gain in the quietest rings. */
static void fill_beside(Plane plane, int64_t raised, int64_t step, const int64_t *order, uint8_t *codes)
{
    for (int64_t b = raised + step; b >= 0 && b < plane.beams && codes[b] == HEARS; b += step) {
        const float limit = 0.5f * (plane.codes[b] == DROWNED ? LOWERED_DB : RAISED_DB);
        if (!(mean_excess(plane, b, order, plane.rings / 4, true) >= limit))
            return;
        codes[b] = DROWNED;
    }
}

/* Judges which beams of a plane are drowned by a source. */
static void find_drowned(Plane plane)
{
    int64_t *order = SCRATCH(int64_t, plane.rings), raised = 0;
    bool stand_out = false;
    const int64_t rings = by_level(plane.middle, plane.rings, order);
    uint8_t *codes = ZEROS(uint8_t, plane.beams);
    const Rings counted = count_rings(plane);
    for (int64_t b = 0; b < plane.beams && 2 * rings >= plane.rings; b++) {
        const bool deaf = plane.codes[b] != SATURATED && is_raised(plane, counted, b, order, rings);
        codes[b] = deaf ? DROWNED : plane.codes[b] == SATURATED ? SATURATED : HEARS;
        raised += deaf;
        stand_out |= deaf && stands_out(plane, b);
    }
    const bool is_source = stand_out && FEW * raised <= plane.beams;
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

/* Lets the gains of a plane's beams follow: by such a share while they are not raised, and while they are. */
static void follow_gains(Plane plane, float learning, float forgetting)
{
    float *restrict rate = SCRATCH(float, plane.beams), *restrict first = SCRATCH(float, plane.beams);
    for (int64_t b = 0; b < plane.beams; b++) {
        const uint8_t code = plane.codes[b];
        rate[b] = code == SATURATED ? NAN : code == DROWNED ? forgetting : learning;
        first[b] = code == SATURATED ? NAN : code == DROWNED ? 0.0f : 1.0f;
    }
    for (int64_t r = 0; r < plane.rings; r++) {
        const float *restrict excess = plane.excess + r * plane.beams;
        float *restrict gain = plane.gain + r * plane.beams;
        for (int64_t b = 0; b < plane.beams; b++) {
            const float known = gain[b] == gain[b] ? gain[b] + rate[b] * (excess[b] - gain[b]) : first[b] * excess[b];
            gain[b] = known == known ? known : gain[b]; /* what is not known, or saturated, teaches nothing */
        }
    }
}

/* Judges the beams of a frame from column `first` on, plane by plane; returns whether any is deaf.
   gain (planes, rings, beams of a plane): of the beams in the parts of their range, dB; codes (beams,): as in
   deaf_beams.py, those of the ping before; both follow. */
KERNEL_BOOL(judge_beams, "rows u1|u2|f4[beams,:] frame, int first, " MISSING ", " MEANING ", float since_s, "
                         "float learning_s, float forgetting_s, out f4[planes,rings,per_plane] gain, out u1[beams] codes")
{
    const int64_t first = INT(1), planes = SIZE(8, 0), rings = SIZE(8, 1), per_plane = SIZE(8, 2);
    const float learning = (float)-expm1(-FLOAT(5) / FLOAT(6)), forgetting = (float)-expm1(-FLOAT(5) / FLOAT(7));
    const Missing missing = missing_at(&arguments[2], SIZE(0, 0), SIZE(0, 1));
    uint8_t *codes = ARRAY(uint8_t, 9);
    bool any = false;
    if (first < 0 || SIZE(0, 1) - first < rings * LOOKED_AT || planes * per_plane != SIZE(0, 0))
        return false;
    for (int64_t p = 0; p < planes; p++) {
        Plane plane = {per_plane, rings, SCRATCH(float, rings * per_plane), ARRAY(float, 8) + p * rings * per_plane,
                       SCRATCH(float, rings), codes + p * per_plane};
        measure_levels(SAMPLES(0), p * per_plane, first, missing, MEANING_AT(3), plane);
        compare(&plane);
        find_drowned(plane);
        follow_gains(plane, learning, forgetting);
    }
    for (int64_t b = 0; b < SIZE(0, 0); b++)
        any |= codes[b] != HEARS;
    return any;
}
