/* Equalization by what stays in its place in the image over pings. */

#include "ods/pipeline/equalize/by_range.h"

/* Updates state (beams, samples), the mean over pings, and fills level (samples,) with its mean over the beams. */
static void update_background(const float *restrict source, float weight, int64_t beams, int64_t samples,
                              float *restrict level, float *restrict state)
{
    memset(level, 0, (size_t)samples * sizeof(float));
    for (int64_t b = 0; b < beams; b++) {
        const float *restrict new = source + b * samples;
        float *restrict mean = state + b * samples;
        for (int64_t j = 0; j < samples; j++) {
            mean[j] += weight * (new[j] - mean[j]);
            level[j] += mean[j];
        }
    }
    for (int64_t j = 0; j < samples; j++)
        level[j] /= (float)beams;
}

/* Fills out with the image over its mean over pings, state, which weight moves towards the image before.

   The mean counts as within a factor of guard of that of its range, which itself is limited by the ranges around. */
KERNEL(equalize_by_background, "f4[beams,samples] source, float weight, float guard, int window, "
                               "out f4[beams,samples] state, out f4[beams,samples] out")
{
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1);
    const float *restrict source = ARRAY(const float, 0);
    const float guard = (float)FLOAT(2);
    float *restrict state = ARRAY(float, 4), *restrict out = ARRAY(float, 5), *restrict level = SCRATCH(float, samples);
    update_background(source, (float)FLOAT(1), beams, samples, level, state);
    limit_levels(level, samples, guard, blocks_around(INT(3)));
    for (int64_t b = 0; b < beams; b++)
        for (int64_t j = 0; j < samples; j++) {
            const int64_t cell = b * samples + j;
            const float raised = larger_f(level[j] / guard, state[cell]);
            const float limited = smaller_f(level[j] * guard, raised);
            out[cell] = source[cell] / (limited > 0.0f ? limited : 1.0f);
        }
}
