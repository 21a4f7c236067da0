/* Which regions are strong enough: over their levels, at the image's border, and among the recorded samples
   (grouping.py, levels.py). */

#include "ods/pipeline/detect/background/rise.h"
#include "ods/pipeline/image/regions.h"
#include "ods/pipeline/image/samples/looked_at.h"
#include "ods/pipeline/image/samples/recorded.h"

/* Width of the border, cells: that of the default filter's half window. */
#define BORDER_BEAMS 2
#define BORDER_SAMPLES 4
/* An image of less than so many borders has none: it would be all border. */
#define LEAST_BORDERS 8

/* Tells whether a run has cells, all in an image of beams x samples, and a region of 1 to `regions`. */
static bool lies_inside(Run run, int64_t beams, int64_t samples, int64_t regions)
{
    return run.beam >= 0 && run.beam < beams && run.first >= 0 && run.first < run.stop && run.stop <= samples
           && run.region >= 1 && run.region <= regions;
}

/* Fills keys with numbers that are in the order of the values: counts, or the bits of floats. */
static void keys_of(const float *restrict values, int64_t count, bool are_counts, int32_t *restrict keys)
{
    if (are_counts) {
        for (int64_t i = 0; i < count; i++)
            keys[i] = (int32_t)values[i];
        return;
    }
    memcpy(keys, values, (size_t)count * sizeof *keys);
    for (int64_t i = 0; i < count; i++)
        keys[i] ^= (keys[i] >> 31) & INT32_MAX;
}

/* Returns the key at a rank, from 0 on, among keys of `bits` bits from `lowest` on: bit by bit. */
static int32_t key_at(const int32_t *keys, int64_t count, int64_t rank, int32_t lowest, int bits)
{
    int64_t found = lowest;
    for (int bit = bits - 1; bit >= 0; bit--) {
        const int32_t limit = (int32_t)(found + ((int64_t)1 << bit) - 1);
        int32_t up_to = 0;
        for (int64_t i = 0; i < count; i++)
            up_to += keys[i] <= limit;
        found += up_to <= rank ? (int64_t)1 << bit : 0;
    }
    return (int32_t)found;
}

/* Returns the level that this share of the recorded samples that hold data reaches; 0 where none does. Looked at are
   some of them, evenly spread, in steps that never fall in with the rows. */
KERNEL_FLOAT(level_of_strongest, RECORDED ", float share")
{
    const Recorded recorded = recorded_at(arguments);
    const bool are_counts = recorded.samples.type != 'f';
    const LookedAt some = look_at(recorded.samples, recorded.beams, 0, 4 * LOOKED_AT, &recorded.missing);
    const int64_t count = some.count;
    if (count == 0)
        return 0.0;
    int32_t *keys = SCRATCH(int32_t, count);
    const double share = FLOAT(arguments_of(RECORDED));
    const int64_t rank = (int64_t)smaller(larger(1.0 - share, 0.0) * (double)count, (double)(count - 1));
    keys_of(some.values, count, are_counts, keys);
    if (are_counts)
        return key_at(keys, count, rank, 0, 16);
    int32_t key = key_at(keys, count, rank, INT32_MIN, 32);
    float level;
    key ^= (key >> 31) & INT32_MAX;
    memcpy(&level, &key, sizeof level);
    return level;
}

/* Fills out with the runs of the regions, `total` of them, that have a cell above `high` that is not in the border, or
   one above `raised` (both rise as the low level does), and a recorded sample that reaches `recorded_level`; renumbered.
   Returns how many runs there are. */
KERNEL_INT(choose_strong, "f4[beams,columns] image, r16[runs] runs, int total, float high, float raised, float "
                          "recorded_level, " RISE ", " RECORDED ", out r16[runs] out")
{
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1), regions = larger_i(INT(2), 0);
    const float *image = ARRAY(const float, 0);
    const Run *runs = ARRAY(const Run, 1), *end = runs + SIZE(1, 0);
    const double high = FLOAT(3), raised = FLOAT(4), recorded_level = FLOAT(5);
    const Rise rise = rise_at(arguments += 6);
    const Recorded recorded = recorded_at(arguments += arguments_of(RISE));
    arguments += arguments_of(RECORDED);
    const int64_t lower = beams >= LEAST_BORDERS * BORDER_BEAMS ? BORDER_BEAMS : 0;
    const int64_t near = samples >= LEAST_BORDERS * BORDER_SAMPLES ? BORDER_SAMPLES : 0;
    const Levels inside = risen(&rise, high, rise.low_power, samples);
    const Levels at_border = risen(&rise, raised, rise.low_power, samples);
    bool *strong = ZEROS(bool, regions), *loud = ZEROS(bool, regions);
    for (const Run *run = runs; run < end; run++) {
        if (!lies_inside(*run, beams, samples, regions))
            continue;
        bool *is_strong = &strong[run->region - 1], *is_loud = &loud[run->region - 1];
        const float *cells = image + run->beam * samples;
        const bool outer = run->beam < lower || run->beam >= beams - lower;
        const float *levels = levels_along(&rise, inside, run->beam, samples);
        const float *higher = levels_along(&rise, at_border, run->beam, samples);
        for (int64_t j = run->first; j < run->stop && !*is_strong; j++)
            *is_strong = cells[j] > (outer || j < near || j >= samples - near ? higher : levels)[j];
        *is_loud = *is_loud || recorded_level <= 0.0 || highest_sample(recorded, *run) >= recorded_level;
    }
    for (int64_t k = 0; k < regions; k++)
        strong[k] &= loud[k];
    return chosen_runs(runs, end - runs, strong, regions, ARRAY(Run, 0)).runs;
}

/* Tells which regions of runs have a cell above the high level of its place in the image. */
KERNEL(reaching, "f4[beams,samples] image, r16[runs] runs, float high, " RISE ", out b1[regions] found")
{
    const int64_t samples = SIZE(0, 1), regions = SIZE(3 + arguments_of(RISE), 0);
    const Rise rise = rise_at(arguments + 3);
    const Levels high = risen(&rise, FLOAT(2), rise.high_power, samples);
    bool *found = ARRAY(bool, 3 + arguments_of(RISE));
    memset(found, 0, (size_t)regions);
    for (int64_t i = 0; i < SIZE(1, 0); i++) {
        const Run run = ARRAY(const Run, 1)[i];
        if (!lies_inside(run, SIZE(0, 0), samples, regions))
            continue;
        const float *cells = ARRAY(const float, 0) + run.beam * samples;
        const float *levels = levels_along(&rise, high, run.beam, samples);
        for (int64_t j = run.first; j < run.stop && !found[run.region - 1]; j++)
            found[run.region - 1] = cells[j] > levels[j];
    }
}
