/* Grey opening: the minimum over a window of an object's size, then the maximum over it. Crests narrower than that, in
   range or across, fall to the level around; larger ones stay as they are. */

#include "kernel.h"

static inline void keep_lower(const float *restrict source, int64_t count, float *restrict target)
{
    for (int64_t j = 0; j < count; j++)
        target[j] = source[j] < target[j] ? source[j] : target[j];
}

static inline void keep_higher(const float *restrict source, int64_t count, float *restrict target)
{
    for (int64_t j = 0; j < count; j++)
        target[j] = source[j] > target[j] ? source[j] : target[j];
}

static inline void keep(bool highest, const float *restrict source, int64_t count, float *restrict target)
{
    if (highest)
        keep_higher(source, count, target);
    else
        keep_lower(source, count, target);
}

/* Fills target (samples,) with the maximum or minimum over `half` samples to either side, cut at the ends. */
static void extreme_along(const float *restrict source, int64_t samples, int64_t half, bool highest,
                          float *restrict target)
{
    memcpy(target, source, (size_t)samples * sizeof(float));
    for (int64_t k = 1; k <= smaller_i(half, samples - 1); k++) {
        keep(highest, source + k, samples - k, target);
        keep(highest, source, samples - k, target + k);
    }
}

/* Fills out with the maximum or minimum over k beams to either side, up to column stops[k - 1]. */
static void extreme_across(const float *restrict image, int64_t beams, int64_t samples, const int64_t *stops,
                           int64_t reach, bool highest, float *restrict out)
{
    for (int64_t b = 0; b < beams; b++) {
        float *target = out + b * samples;
        memcpy(target, image + b * samples, (size_t)samples * sizeof(float));
        for (int64_t k = 1; k <= reach; k++) {
            if (b - k >= 0)
                keep(highest, image + (b - k) * samples, stops[k - 1], target);
            if (b + k < beams)
                keep(highest, image + (b + k) * samples, stops[k - 1], target);
        }
    }
}

/* Fills out with source opened by a window of `half` samples to either side, and of k beams up to column stops[k - 1].

   work: as large as the image. */
KERNEL(open_image, "f4[beams,samples] source, int half, i8[:] stops, out f4[beams,samples] work, "
                   "out f4[beams,samples] out")
{
    const float *source = ARRAY(const float, 0);
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1), half = INT(1), reach = SIZE(2, 0);
    const int64_t *stops = ARRAY(const int64_t, 2);
    float *work = ARRAY(float, 3), *out = ARRAY(float, 4);
    for (int64_t k = 0; k < 2; k++) {
        const bool highest = k == 1;
        for (int64_t b = 0; b < beams; b++)
            extreme_along((highest ? out : source) + b * samples, samples, half, highest, work + b * samples);
        extreme_across(work, beams, samples, stops, reach, highest, out);
    }
}
