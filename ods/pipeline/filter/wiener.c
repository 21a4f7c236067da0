/* Lim's adaptive filter (`wiener` of wiener.py): means and variances first, then, since the noise is the mean of all
   variances, the filtered samples. */

#include "ods/pipeline/filter/rows/ring.h"
#include "ods/pipeline/image/gained_image.h"

/* Fills mean and square (samples,) with the means over the range of a mirrored row and of its squares. */
static void average_row(const float *padded, int64_t window, float weight, int64_t samples, float *restrict mean,
                        float *restrict square)
{
    for (int64_t j = 0; j < samples; j += BLOCK) {
        Lanes sums[LANES_OF_BLOCK] = {{0}}, squares[LANES_OF_BLOCK] = {{0}};
        for (int64_t k = 0; k < window; k++)
            for (int64_t i = 0; i < LANES_OF_BLOCK; i++) {
                const Lanes x = load(padded + j + k + i * LANES);
                sums[i] += x;
                squares[i] += x * x;
            }
        for (int64_t i = 0; i < LANES_OF_BLOCK; i++) {
            sums[i] *= weight;
            squares[i] *= weight;
        }
        store_block(sums, samples - j, mean + j);
        store_block(squares, samples - j, square + j);
    }
}

/* The same for a window of 9: sums of three are added up, which takes two thirds of the loads. */
static void average_row_of_9(const float *restrict padded, float weight, int64_t samples, float *restrict mean,
                             float *restrict square)
{
    float sums[COLUMNS + 6], squares[COLUMNS + 6];
    for (int64_t begin = 0; begin < samples; begin += COLUMNS) {
        const float *restrict row = padded + begin;
        float *restrict mean_here = mean + begin, *restrict square_here = square + begin;
        const int64_t count = smaller_i(COLUMNS, samples - begin);
        for (int64_t j = 0; j < count + 6; j++) {
            sums[j] = row[j] + row[j + 1] + row[j + 2];
            squares[j] = row[j] * row[j] + row[j + 1] * row[j + 1] + row[j + 2] * row[j + 2];
        }
        for (int64_t j = 0; j < count; j++) {
            mean_here[j] = weight * (sums[j] + sums[j + 3] + sums[j + 6]);
            square_here[j] = weight * (squares[j] + squares[j + 3] + squares[j + 6]);
        }
    }
}

/* Turns the mean squares into variances, in place, and returns their sum: of BLOCK sums, as one would wait for
   itself. */
static float to_variances(const float *restrict mean, int64_t samples, float *restrict square)
{
    float sums[BLOCK] = {0.0f}, total = 0.0f;
    const int64_t whole = samples - samples % BLOCK;
    for (int64_t j = 0; j < samples; j++)
        square[j] = larger_f(square[j] - mean[j] * mean[j], 0.0f);
    for (int64_t j = 0; j < whole; j += BLOCK)
        for (int64_t k = 0; k < BLOCK; k++)
            sums[k] += square[j + k];
    for (int64_t j = whole; j < samples; j++)
        total += square[j];
    for (int64_t k = 0; k < BLOCK; k++)
        total += sums[k];
    return total;
}

/* Turns the means into the filtered row, in place. */
static void draw_to_mean(const float *restrict row, const float *restrict variance, float noise, int64_t samples,
                         float *restrict mean)
{
    for (int64_t j = 0; j < samples; j++) {
        const float whole = larger_f(variance[j], noise);
        const float share = (whole - noise) / (whole + 1e-30f);
        mean[j] += share * (row[j] - mean[j]);
    }
}

/* Fills out with the image filtered by Lim's rule; the filter is that of the window. variance: work space. */
KERNEL(wiener_filter, GAINED_IMAGE ", " SEPARABLE_FILTER ", out f4[beams,samples] variance, out f4[beams,samples] out")
{
    const GainedImage image = gained_image_at(arguments);
    const SeparableFilter filter = separable_filter_at(arguments + arguments_of(GAINED_IMAGE));
    arguments += arguments_of(GAINED_IMAGE) + arguments_of(SEPARABLE_FILTER);
    float *variance = ARRAY(float, 0), *out = ARRAY(float, 1);
    const int64_t beams = image.beams, samples = image.samples, half = filter.half, reach = filter.reach;
    float *padded = SCRATCH(float, samples + 2 * half + BLOCK);
    const Ring means = new_ring(reach, beams, samples), squares = new_ring(reach, beams, samples);
    double noise = 0.0;
    for (int64_t b = 0; b < beams + reach; b++) {
        float *mean = out + larger_i(0, b - reach) * samples, *square = variance + larger_i(0, b - reach) * samples;
        if (b < beams) {
            load_mirrored(image, b, half, padded);
            float *mean_along = reach == 0 ? mean : row_of_ring(&means, b);
            float *square_along = reach == 0 ? square : row_of_ring(&squares, b);
            if (half == 4)
                average_row_of_9(padded, filter.along[0], samples, mean_along, square_along);
            else
                average_row(padded, 2 * half + 1, filter.along[0], samples, mean_along, square_along);
        }
        if (b < reach)
            continue;
        if (reach > 0) {
            weigh_ring(&means, filter.across, b - reach, mean);
            weigh_ring(&squares, filter.across, b - reach, square);
        }
        noise += (double)to_variances(mean, samples, square);
    }
    noise /= (double)(beams * samples);
    for (int64_t b = 0; b < beams; b++) { /* read once more: cheaper than to keep a third image */
        load_row(image, b, padded);
        draw_to_mean(padded, variance + b * samples, (float)noise, samples, out + b * samples);
    }
}
