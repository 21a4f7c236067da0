/* Equalization by range: the average over the beams is brought to 1 [SSIE, Image processing, stage 1]. */

#include "ods/pipeline/equalize/by_range.h"
#include "ods/pipeline/filter/rows/halving.h"
#include "ods/pipeline/filter/rows/lanes.h"
#include "ods/pipeline/image/gained_image.h"

#define COUNTS_OF(COUNT, b) ((const COUNT *)(image.cells.data + (b) * image.cells.row_bytes) + image.first)

/* Of counts of one type, the body of measure_counts; ROWS at a time, the last ones one by one. */
#define MEASURE_COUNTS(COUNT, SUM)                                                                                     \
    {                                                                                                                  \
        SUM *restrict sums = ZEROS(SUM, samples);                                                                      \
        COUNT *restrict tops = ZEROS(COUNT, samples);                                                                  \
        int64_t b = 0;                                                                                                 \
        for (; b + ROWS <= image.beams; b += ROWS) {                                                                   \
            const COUNT *restrict one = COUNTS_OF(COUNT, b), *restrict two = COUNTS_OF(COUNT, b + 1);                  \
            const COUNT *restrict three = COUNTS_OF(COUNT, b + 2), *restrict four = COUNTS_OF(COUNT, b + 3);           \
            for (int64_t j = 0; j < samples; j++) {                                                                    \
                const COUNT left = one[j] > two[j] ? one[j] : two[j];                                                  \
                const COUNT right = three[j] > four[j] ? three[j] : four[j];                                           \
                const COUNT top = left > right ? left : right;                                                         \
                sums[j] += (SUM)(one[j] + two[j] + three[j] + four[j]);                                                \
                tops[j] = top > tops[j] ? top : tops[j];                                                               \
            }                                                                                                          \
        }                                                                                                              \
        for (; b < image.beams; b++) {                                                                                 \
            const COUNT *restrict row = COUNTS_OF(COUNT, b);                                                           \
            for (int64_t j = 0; j < samples; j++) {                                                                    \
                sums[j] += row[j];                                                                                     \
                tops[j] = row[j] > tops[j] ? row[j] : tops[j];                                                         \
            }                                                                                                          \
        }                                                                                                              \
        for (int64_t j = 0; j < samples; j++) {                                                                        \
            mean[j] = (float)sums[j] * share + image.offset;                                                           \
            highest[j] = (float)tops[j] + image.offset;                                                                \
        }                                                                                                              \
    }

/* Fills mean and highest (samples,) with mean and maximum over the beams of recorded counts, which are summed up as
   integers: faster than amplitudes. */
static void measure_counts(GainedImage image, float *restrict mean, float *restrict highest)
{
    const int64_t samples = image.samples;
    const float share = (float)(1.0 / (double)image.beams);
    if (image.cells.type == 'H')
        MEASURE_COUNTS(uint16_t, uint32_t)
    else if (image.beams <= UINT16_MAX / UINT8_MAX)
        MEASURE_COUNTS(uint8_t, uint16_t)
    else
        MEASURE_COUNTS(uint8_t, uint32_t)
}

/* The same, of amplitudes. */
static void measure_amplitudes(GainedImage image, float *restrict mean, float *restrict highest)
{
    const float share = (float)(1.0 / (double)image.beams);
    float *restrict one = SCRATCH(float, image.samples), *restrict two = SCRATCH(float, image.samples);
    for (int64_t j = 0; j < image.samples; j++)
        mean[j] = highest[j] = 0.0f;
    for (int64_t b = 0; b + 1 < image.beams; b += 2) {
        load_row(image, b, one);
        load_row(image, b + 1, two);
        for (int64_t j = 0; j < image.samples; j++) {
            mean[j] += one[j] + two[j];
            highest[j] = larger_f(one[j], larger_f(two[j], highest[j]));
        }
    }
    if (image.beams % 2 != 0) {
        load_row(image, image.beams - 1, one);
        for (int64_t j = 0; j < image.samples; j++) {
            mean[j] += one[j];
            highest[j] = larger_f(one[j], highest[j]);
        }
    }
    for (int64_t j = 0; j < image.samples; j++)
        mean[j] *= share;
}

/* Fills mean and highest (samples,) with mean and maximum over the beams. */
static void measure(GainedImage image, float *mean, float *highest)
{
    if (image.plain && image.cells.type != 'f')
        measure_counts(image, mean, highest);
    else
        measure_amplitudes(image, mean, highest);
}

/* Fills gain (samples,) with before / level; 0 where the level is 0. */
static void to_gain(const float *restrict level, const float *restrict before, int64_t samples, float *restrict gain)
{
    for (int64_t j = 0; j < samples; j++) {
        const float divided = before[j] / (level[j] > 0.0f ? level[j] : 1.0f);
        gain[j] = level[j] > 0.0f ? divided : 0.0f;
    }
}

/* Fills gain with the present one / level: the mean over the beams, as limit_levels limits it, or side_lobe times the
   highest amplitude where that is higher. */
KERNEL(mean_range_gain, GAINED_IMAGE ", float side_lobe, float guard, int window, out f4[1,samples] new_gain")
{
    const GainedImage image = gained_image_at(arguments);
    arguments += arguments_of(GAINED_IMAGE);
    const float side_lobe = (float)FLOAT(0), guard = (float)FLOAT(1);
    float *restrict level = SCRATCH(float, image.samples), *restrict highest = SCRATCH(float, image.samples);
    measure(image, level, highest);
    limit_levels(level, image.samples, guard, blocks_around(INT(2)));
    for (int64_t j = 0; j < image.samples; j++)
        level[j] = larger_f(side_lobe * highest[j], level[j]);
    to_gain(level, image.gain, image.samples, ARRAY(float, 3));
}

/* Turns level (samples,), the means, into the medians over the beams of the image.

   By halving an interval: the median of what is not negative is at most twice the mean. */
static void column_medians(GainedImage image, float *restrict level)
{
    const int64_t samples = image.samples;
    const float half = (float)(0.5 * (double)image.beams);
    float *restrict low = ZEROS(float, samples), *restrict high = SCRATCH(float, samples);
    float *restrict count = SCRATCH(float, samples), *restrict row = SCRATCH(float, samples);
    for (int64_t j = 0; j < samples; j++)
        high[j] = 2.0f * level[j];
    for (int64_t step = 0; step < HALVINGS; step++) {
        for (int64_t j = 0; j < samples; j++) {
            level[j] = 0.5f * (low[j] + high[j]);
            count[j] = 0.0f;
        }
        for (int64_t b = 0; b < image.beams; b++) {
            load_row(image, b, row);
            for (int64_t j = 0; j < samples; j++)
                count[j] += row[j] > level[j] ? 1.0f : 0.0f;
        }
        for (int64_t j = 0; j < samples; j++) {
            low[j] = count[j] >= half ? level[j] : low[j];
            high[j] = count[j] >= half ? high[j] : level[j];
        }
    }
}

/* Fills gain with the present one / level: the median over the beams as the mean that speckle of that median has. */
KERNEL(median_range_gain, GAINED_IMAGE ", float guard, int window, out f4[1,samples] new_gain")
{
    const GainedImage image = gained_image_at(arguments);
    arguments += arguments_of(GAINED_IMAGE);
    float *restrict level = SCRATCH(float, image.samples), *restrict highest = SCRATCH(float, image.samples);
    measure(image, level, highest);
    const float speckle_mean = sqrtf((float)(PI / log(16.0))); /* of a Rayleigh distribution, in multiples of its median */
    column_medians(image, level);
    for (int64_t j = 0; j < image.samples; j++)
        level[j] *= speckle_mean;
    limit_levels(level, image.samples, (float)FLOAT(0), blocks_around(INT(1)));
    to_gain(level, image.gain, image.samples, ARRAY(float, 2));
}
