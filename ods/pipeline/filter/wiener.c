/* Lim's adaptive filter: mean + (sample - mean) * max(0, variance - noise) / variance, over a window along the beam, or
   along and across the beams; the noise is the mean of all local variances (J. S. Lim, Two-Dimensional Signal and Image
   Processing, 1990, ch. 9).

   The image is read twice, first for the noise: to work out means and variances once more takes less time than to write
   them and to read them again. */

#include "ods/pipeline/filter/linear.h"
#include "ods/pipeline/image/gained_image.h"

/* Work space: rows of samples, their means and their mean squares. */
typedef struct {
    float *padded, *mean, *square;
    Ring means, squares;
} Work;

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

/* Returns the sum of the variances. */
static float sum_of_variances(const float *restrict mean, const float *restrict square, int64_t samples)
{
    float total = 0.0f;
    for (int64_t j = 0; j < samples; j++)
        total += larger_f(square[j] - mean[j] * mean[j], 0.0f);
    return total;
}

/* Fills out with the row filtered; noise: its variance. */
static void draw_to_mean(const float *restrict row, const float *restrict mean, const float *restrict square, float noise,
                         int64_t samples, float *restrict out)
{
    for (int64_t j = 0; j < samples; j++) {
        const float whole = larger_f(square[j] - mean[j] * mean[j], noise);
        const float share = (whole - noise) / (whole + 1e-30f);
        out[j] = mean[j] + share * (row[j] - mean[j]);
    }
}

/* Returns the sum of the variances around all samples. Where out is given, fills it with the image filtered. */
static double pass(GainedImage image, SeparableFilter filter, const Work *work, float noise, float *out)
{
    const int64_t reach = filter.reach, samples = image.samples;
    double total = 0.0;
    for (int64_t b = 0; b < image.beams + reach; b++) {
        const int64_t row = b - reach;
        if (b < image.beams) {
            load_mirrored(image, b, filter.half, work->padded);
            average_row(work->padded, 2 * filter.half + 1, filter.along[0], samples,
                        reach == 0 ? work->mean : row_of_ring(&work->means, b),
                        reach == 0 ? work->square : row_of_ring(&work->squares, b));
        }
        if (row < 0)
            continue;
        if (reach > 0) {
            weigh_ring(&work->means, filter.across, row, work->mean);
            weigh_ring(&work->squares, filter.across, row, work->square);
        }
        if (out == NULL) {
            total += (double)sum_of_variances(work->mean, work->square, samples);
        } else {
            load_row(image, row, work->padded);
            draw_to_mean(work->padded, work->mean, work->square, noise, samples, out + row * samples);
        }
    }
    return total;
}

/* Fills out with the image filtered by Lim's rule; the filter is that of the window. */
KERNEL(wiener_filter, GAINED_IMAGE ", " SEPARABLE_FILTER ", out f4[beams,samples] out")
{
    const GainedImage image = gained_image_at(arguments);
    const SeparableFilter filter = separable_filter_at(arguments + GAINED_IMAGE_ARGUMENTS);
    float *out = ARRAY(float, GAINED_IMAGE_ARGUMENTS + SEPARABLE_FILTER_ARGUMENTS);
    const int64_t samples = image.samples;
    const Work work = {SCRATCH(float, samples + 2 * filter.half + BLOCK), SCRATCH(float, samples), SCRATCH(float, samples),
                       new_ring(filter.reach, image.beams, samples), new_ring(filter.reach, image.beams, samples)};
    const double total = pass(image, filter, &work, 0.0f, NULL);
    pass(image, filter, &work, (float)(total / (double)(image.beams * samples)), out);
}
