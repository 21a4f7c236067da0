/* Echoes that reach the strongest of the recorded samples (grouping.py). */

#include "ods/pipeline/detect/regions/inside.h"
#include "ods/pipeline/image/samples/looked_at.h"
#include "ods/pipeline/image/samples/recorded.h"

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

/* Returns the level that this share of the recorded samples that hold data reaches; 0 where none does. */
KERNEL_FLOAT(level_of_strongest, RECORDED ", float share")
{
    const Recorded recorded = recorded_at(arguments);
    const bool are_counts = recorded.samples.type != 'f';
    const LookedAt some = look_at(recorded.samples, recorded.beams, 0, &recorded.missing);
    const int64_t count = some.count;
    if (count == 0)
        return 0.0;
    int32_t *keys = SCRATCH(int32_t, count);
    const double others = smaller(larger(1.0 - FLOAT(arguments_of(RECORDED)), 0.0) * (double)count, (double)(count - 1));
    const int64_t rank = (int64_t)others;
    keys_of(some.values, count, are_counts, keys);
    if (are_counts)
        return key_at(keys, count, rank, 0, 16);
    int32_t key = key_at(keys, count, rank, INT32_MIN, 32);
    float level;
    key ^= (key >> 31) & INT32_MAX;
    memcpy(&level, &key, sizeof level);
    return level;
}

/* Tells which regions have a recorded sample that reaches the level; all do, if that is 0 or less. */
KERNEL(strong_as_recorded, RECORDED ", r16[runs] runs, float level, out b1[regions] strong")
{
    const Recorded recorded = recorded_at(arguments);
    arguments += arguments_of(RECORDED);
    const Run *runs = ARRAY(const Run, 0);
    bool *strong = ARRAY(bool, 2);
    memset(strong, FLOAT(1) <= 0.0, (size_t)SIZE(2, 0));
    for (int64_t i = 0; i < SIZE(0, 0); i++)
        if (lies_inside(runs[i], recorded.beams, recorded.columns, SIZE(2, 0)) && !strong[runs[i].region - 1])
            strong[runs[i].region - 1] = highest_sample(recorded, runs[i]) >= FLOAT(1);
}
