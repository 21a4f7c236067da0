/* Separable symmetric filters, along the beam or along and across [SSIE, Image processing, stage 2].

   The image is mirrored at the range ends and at the fan's edges. Echoes keep their place. */

#include "ods/pipeline/filter/linear.h"
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

/* Fills out with the image convolved along the range and from beam to beam. */
KERNEL(filter_plane, GAINED_IMAGE ", " SEPARABLE_FILTER ", out f4[beams,samples] out")
{
    const GainedImage image = gained_image_at(arguments);
    const SeparableFilter filter = separable_filter_at(arguments + GAINED_IMAGE_ARGUMENTS);
    float *out = ARRAY(float, GAINED_IMAGE_ARGUMENTS + SEPARABLE_FILTER_ARGUMENTS);
    const int64_t beams = image.beams, samples = image.samples, half = filter.half, reach = filter.reach;
    float *padded = SCRATCH(float, samples + 2 * half + BLOCK);
    const Ring ring = new_ring(reach, beams, samples);
    for (int64_t b = 0; b < beams + reach; b++) {
        float *target = out + larger_i(0, b - reach) * samples;
        if (b < beams) {
            load_mirrored(image, b, half, padded);
            convolve_row(padded, filter.along, half, samples, reach == 0 ? target : row_of_ring(&ring, b));
        }
        if (b >= reach && reach > 0)
            weigh_ring(&ring, filter.across, b - reach, target);
    }
}
