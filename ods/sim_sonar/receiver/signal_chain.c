/* From the area that each sample receives to the amplitude that the sonar shows. */

#include "ods/sim_sonar/receiver/speckle/random_field.h"

/* Keeps a share of the power finite where there is none. */
#define LEAST_POWER 1e-30f

/* Sets `bits` to the hashes of the receiver's noise in one ping, which `salt` makes another one than in the others. */
static void refresh(const uint32_t *restrict keys, uint32_t salt, int64_t count, uint32_t *restrict bits)
{
    for (int64_t j = 0; j < count; j++)
        bits[j] = hash32(hash32(keys[j]) + salt);
}

/* Turns `row`, the echoes' normal numbers, into those of echo and noise together; `floor`, the noise's mean power, into
   the amplitude of both. `frozen`: see `frozen_correlation`. */
static void combine(float *restrict row, const float *restrict fresh, const double *restrict area,
                    const float *restrict echo, float *restrict floor, const float *frozen, int64_t count)
{
    const float a = frozen[0], b = frozen[1], c = frozen[2];
    for (int64_t j = 0; j < count; j++) {
        const float signal = (float)area[j] * echo[j];
        const float power = larger_f(LEAST_POWER, signal + floor[j]);
        const float share = signal / power;
        const float stays = share * share * (1.0f + (1.0f - share) * (a + share * (b + share * c)));
        row[j] = sqrtf(stays) * row[j] + sqrtf(1.0f - stays) * fresh[j];
        floor[j] = sqrtf(power);
    }
}

/* The amplitudes of speckle at normal numbers even in +-reach. */
typedef struct {
    const float *amplitude;
    int64_t nodes;
    double reach;
} Law;

/* Turns the normal numbers in `row` into those of the speckle's law, times `amplitude`. */
static void apply_law(float *restrict row, const float *restrict amplitude, Law law, int64_t count)
{
    const float *restrict table = law.amplitude;
    const float scale = (float)((double)(law.nodes - 1) / (2.0 * law.reach));
    const float middle = (float)(0.5 * (double)(law.nodes - 1)), last = (float)((double)law.nodes - 1.001);
    for (int64_t j = 0; j < count; j++) {
        const float place = smaller_f(larger_f(row[j] * scale + middle, 0.0f), last);
        const int32_t node = (int32_t)place;
        const float share = place - (float)node;
        row[j] = amplitude[j] * (table[node] + share * (table[node + 1] - table[node]));
    }
}

static void amplify(float *restrict row, const float *restrict over_range, float over_beam, float saturation,
                    int64_t count)
{
    for (int64_t j = 0; j < count; j++)
        row[j] = smaller_f(saturation, row[j] * over_range[j] * over_beam);
}

/* Turns `image`, the normal numbers of the echoes' speckle, into amplitude. The arguments: `Levels` and `Chance` of
   signal_chain.py. A number that is none stays none: nothing hides that levels are too high. */
LONG_KERNEL(receive,
            "f8[beams,samples] area, "
            "f4[samples] echo, f4[samples] noise, f4[sources,beams] received, f4[sources,samples] arriving, "
            "f4[samples] over_range, f4[beams] over_beams, float saturation, "
            "u4[beams,samples] keys, int salt, " NORMAL_TABLE ", f4[:] law, f4[3] frozen, float reach, "
            "out f4[beams,samples] image")
{
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1), sources = SIZE(3, 0);
    const Law law = {ARRAY(float, 11), SIZE(11, 0), FLOAT(13)};
    float *floor = SCRATCH(float, samples), *fresh = SCRATCH(float, samples);
    uint32_t *bits = SCRATCH(uint32_t, samples);
    for (int64_t beam = 0; beam < beams; beam++) {
        float *row = ARRAY(float, 14) + beam * samples;
        memcpy(floor, ARRAY(float, 2), (size_t)samples * sizeof *floor);
        for (int64_t source = 0; source < sources; source++)
            add_times(floor, ARRAY(float, 3)[source * beams + beam], ARRAY(float, 4) + source * samples, samples);
        refresh(ARRAY(uint32_t, 8) + beam * samples, (uint32_t)INT(9), samples, bits);
        normals_of(bits, ARRAY(float, 10), samples, fresh);
        combine(row, fresh, ARRAY(double, 0) + beam * samples, ARRAY(float, 1), floor, ARRAY(float, 12), samples);
        apply_law(row, floor, law, samples);
        amplify(row, ARRAY(float, 5), ARRAY(float, 6)[beam], (float)FLOAT(7), samples);
    }
}
