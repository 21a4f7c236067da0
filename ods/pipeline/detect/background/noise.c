/* What an image looks like where nothing is: quantiles of its cells, by a histogram of some of them. */

#include "kernel.h"

#define BINS 1024
/* The histogram reaches to this multiple of the mean; all that is higher goes into its last bin. */
#define SPAN 8.0
/* The mean, which only sets the width of the bins, is taken of every so many-th of the cells looked at. */
#define FEWER 8

/* Returns the mean of every step-th cell that is above 0; NaN where there is none. */
static double mean_above_0(const float *cells, int64_t count, int64_t step)
{
    float total = 0.0f, above = 0.0f;
    for (int64_t i = 0; i < count; i += step) {
        const bool positive = cells[i] > 0.0f;
        total += positive ? cells[i] : 0.0f;
        above += positive ? 1.0f : 0.0f;
    }
    return total / above;
}

/* Returns the bins that an amplitude of 1 is worth, by the mean of some cells above 0; 0 where it is not finite. */
static double bins_in_unit(const float *cells, int64_t count)
{
    double mean = mean_above_0(cells, count, FEWER);
    if (isnan(mean))
        mean = mean_above_0(cells, count, 1);
    return isfinite(mean) ? BINS / (SPAN * mean) : 0.0;
}

/* Counts cells above 0 into bins of 1 / unit, every other one into a histogram of its own, as many are alike and each
   count of a bin waits for the one before; returns how many there are. */
static int64_t fill_histogram(const float *restrict cells, int64_t count, float unit, int32_t *restrict histogram)
{
    const float last = BINS - 1;
    int32_t *restrict bin = SCRATCH(int32_t, count);
    for (int64_t i = 0; i < count; i++) {
        const float place = cells[i] * unit;
        const int32_t inside = (int32_t)(place < last ? larger_f(place, 0.0f) : last);
        bin[i] = place > 0.0f ? inside : BINS; /* the one behind the last counts the others, NaN too */
    }
    int32_t *restrict other = ZEROS(int32_t, BINS + 1);
    for (int64_t i = 0; i + 1 < count; i += 2) {
        histogram[bin[i]]++;
        other[bin[i + 1]]++;
    }
    if (count % 2 != 0)
        histogram[bin[count - 1]]++;
    for (int64_t k = 0; k <= BINS; k++)
        histogram[k] += other[k];
    return count - histogram[BINS];
}

/* Returns where the running sum of the histogram reaches `rank`, in bins, interpolated. */
static double quantile(const int32_t *histogram, double rank)
{
    int64_t below = 0;
    for (int64_t k = 0; k < BINS; k++) {
        if ((double)(below + histogram[k]) >= rank)
            return (double)k + (rank - (double)below) / (double)larger_i(histogram[k], 1);
        below += histogram[k];
    }
    return BINS;
}

/* Fills out with quantiles of every stride-th cell that is above 0; zeros when there is none, or their mean is not
   finite. */
KERNEL(noise_quantiles, "f4[beams,samples] image, int stride, f8[shares] shares, out f8[shares] out")
{
    const float *image = ARRAY(const float, 0);
    const int64_t stride = larger_i(INT(1), 1), count = (SIZE(0, 0) * SIZE(0, 1) + stride - 1) / stride;
    const double *shares = ARRAY(const double, 2);
    double *out = ARRAY(double, 3);
    float *restrict cells = SCRATCH(float, count);
    int32_t *histogram = ZEROS(int32_t, BINS + 1);
    for (int64_t i = 0; i < count; i++)
        cells[i] = image[stride * i];
    const double unit = bins_in_unit(cells, count);
    const double counted = unit > 0.0 ? (double)fill_histogram(cells, count, (float)unit, histogram) : 0.0;
    for (int64_t k = 0; k < SIZE(2, 0); k++)
        out[k] = unit > 0.0 ? quantile(histogram, shares[k] * counted) / unit : 0.0;
}
