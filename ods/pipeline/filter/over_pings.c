/* Filters over pings: recursive mean and median. Amplitudes below 0: not known. */

#include "kernel.h"

/* Moves out, the former mean or below 0 where there is none, towards source by weight. */
KERNEL(blend, "f4[beams,samples] source, float weight, out f4[beams,samples] out")
{
    const float *restrict source = ARRAY(const float, 0);
    const float weight = (float)FLOAT(1);
    float *restrict out = ARRAY(float, 2);
    for (int64_t k = 0; k < SIZE(0, 0) * SIZE(0, 1); k++) {
        const float old = out[k] >= 0.0f ? out[k] : source[k];
        out[k] = old + weight * (source[k] - old);
    }
}

/* Sorts the known values of a cell into work, those of images that are `cells` apart, and returns how many they are. */
static int64_t sort_known(const float *first, int64_t cells, int64_t count, float *work)
{
    int64_t known = 0;
    for (int64_t k = 0; k < count; k++) {
        const float value = first[k * cells];
        if (value < 0.0f)
            continue;
        int64_t place = known++;
        for (; place > 0 && work[place - 1] > value; place--)
            work[place] = work[place - 1];
        work[place] = value;
    }
    return known;
}

/* Fills out with the (lower) median over the first `count` images of the stack, unknown ones left out. */
KERNEL(median_of_images, "f4[images,beams,samples] stack, int count, out f4[beams,samples] out")
{
    const int64_t cells = SIZE(0, 1) * SIZE(0, 2), count = smaller_i(INT(1), SIZE(0, 0));
    float *out = ARRAY(float, 2), *work = SCRATCH(float, SIZE(0, 0));
    for (int64_t j = 0; j < cells; j++) {
        const int64_t known = sort_known(ARRAY(const float, 0) + j, cells, count, work);
        out[j] = known > 0 ? work[(known - 1) / 2] : 0.0f;
    }
}
