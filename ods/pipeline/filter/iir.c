/* Recursive filter in range, run both ways: no delay, and a cost that does not depend on its length. */

#include "ods/pipeline/filter/rows/lanes.h"
#include "ods/pipeline/image/gained_image.h"

/* Fills left with the sums of the samples up to each of ROWS rows (samples,), weighed by pole^distance. */
static void sum_from_left(float *const *rows, float pole, int64_t samples, float *const *left)
{
    float total[ROWS] = {0};
    for (int64_t j = 0; j < samples; j++)
        for (int64_t k = 0; k < ROWS; k++)
            left[k][j] = total[k] = rows[k][j] + pole * total[k];
}

/* Adds to left the sums of the samples behind each. */
static void add_from_right(float *const *rows, float pole, int64_t samples, float *const *left)
{
    float total[ROWS] = {0};
    for (int64_t j = samples - 1; j >= 0; j--)
        for (int64_t k = 0; k < ROWS; k++) {
            left[k][j] += pole * total[k];
            total[k] = rows[k][j] + pole * total[k];
        }
}

/* Fills out with the image's samples weighted by pole^distance on both sides; scale (samples,): 1 / sum of weights.

   At an end the missing side is left out. */
KERNEL(two_way, GAINED_IMAGE ", float pole, f4[samples] scale, out f4[beams,samples] out")
{
    const GainedImage image = gained_image_at(arguments);
    const int64_t samples = image.samples;
    const float pole = (float)FLOAT(arguments_of(GAINED_IMAGE));
    const float *restrict scale = ARRAY(const float, arguments_of(GAINED_IMAGE) + 1);
    float *out = ARRAY(float, arguments_of(GAINED_IMAGE) + 2), *rows[ROWS], *sums[ROWS];
    for (int64_t k = 0; k < ROWS; k++) {
        rows[k] = SCRATCH(float, samples);
        sums[k] = SCRATCH(float, samples);
    }
    for (int64_t b = 0; b < image.beams; b += ROWS) {
        const int64_t count = smaller_i(ROWS, image.beams - b);
        for (int64_t k = 0; k < ROWS; k++)
            load_row(image, smaller_i(b + k, image.beams - 1), rows[k]);
        sum_from_left(rows, pole, samples, sums);
        add_from_right(rows, pole, samples, sums);
        for (int64_t k = 0; k < count; k++) {
            float *restrict target = out + (b + k) * samples;
            for (int64_t j = 0; j < samples; j++)
                target[j] = sums[k][j] * scale[j];
        }
    }
}
