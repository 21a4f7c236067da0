/* Separable symmetric filters, along the beam or along and across [SSIE, Image processing, stage 2].

   The image is mirrored at the range ends and at the fan's edges. Echoes keep their place. */

#include "ods/pipeline/filter/rows/ring.h"
#include "ods/pipeline/image/gained_image.h"

/* Fills target (samples,) with a mirrored row convolved: padded (samples + 2 half,), weights (half + 1,). */
static void convolve_row(const float *padded, const float *weights, int64_t half, int64_t samples,
                         float *restrict target)
{
    for (int64_t j = 0; j < samples; j += BLOCK) {
        const float *row = padded + half + j;
        Lanes sums[LANES_OF_BLOCK];
        for (int64_t i = 0; i < LANES_OF_BLOCK; i++)
            sums[i] = weights[0] * load(row + i * LANES);
        for (int64_t k = 1; k <= half; k++)
            for (int64_t i = 0; i < LANES_OF_BLOCK; i++)
                sums[i] += weights[k] * (load(row + i * LANES - k) + load(row + i * LANES + k));
        store_block(sums, samples - j, target + j);
    }
}

/* The same for a moving average of 9: sums of three are added up, which takes two thirds of the loads.

   triples (samples + 6,): work space. */
static void average_row_of_9(const float *restrict padded, int64_t samples, float *restrict triples,
                             float *restrict target)
{
    for (int64_t j = 0; j < samples + 6; j++)
        triples[j] = padded[j] + padded[j + 1] + padded[j + 2];
    for (int64_t j = 0; j < samples; j++)
        target[j] = (1.0f / 9.0f) * (triples[j] + triples[j + 3] + triples[j + 6]);
}

/* Fills out with the image convolved along the range and from beam to beam. */
KERNEL(filter_plane, GAINED_IMAGE ", " SEPARABLE_FILTER ", out f4[beams,samples] out")
{
    const GainedImage image = gained_image_at(arguments);
    const SeparableFilter filter = separable_filter_at(arguments + arguments_of(GAINED_IMAGE));
    float *out = ARRAY(float, arguments_of(GAINED_IMAGE) + arguments_of(SEPARABLE_FILTER));
    const int64_t beams = image.beams, samples = image.samples, half = filter.half, reach = filter.reach;
    float *padded = SCRATCH(float, samples + 2 * half + BLOCK);
    float *triples = SCRATCH(float, samples + 6);
    const bool averages_9 = half == 4 && filter.along[4] == filter.along[0];
    const Ring ring = new_ring(reach, beams, samples);
    for (int64_t b = 0; b < beams + reach; b++) {
        float *target = out + larger_i(0, b - reach) * samples;
        if (b < beams) {
            float *along = reach == 0 ? target : row_of_ring(&ring, b);
            load_mirrored(image, b, half, padded);
            if (averages_9)
                average_row_of_9(padded, samples, triples, along);
            else
                convolve_row(padded, filter.along, half, samples, along);
        }
        if (b >= reach && reach > 0)
            weigh_ring(&ring, filter.across, b - reach, target);
    }
}
