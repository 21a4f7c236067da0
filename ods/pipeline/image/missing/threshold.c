/* What is below a sonar's own threshold: where that is, and speckle in its place. See threshold.py. */

#include "ods/pipeline/filter/rows/lanes.h"
#include "ods/pipeline/image/missing/fill.h"
#include "ods/pipeline/image/samples/looked_at.h"

/* Of the mean of what passes: the threshold is at least that, as images that are computed have tails without end. */
#define FAINTEST 1e-3
/* Stands for no sample at all, where nobody knows how quiet it is: a sixth of the threshold. */
#define SILENT exp(-36.0)

/* Returns, as LANES minima, so that it vectorises though NaN is honoured, the lowest of the values over `bottom`; INFINITY where there is none. */
static float lowest_over(float bottom, const float *values, int64_t count)
{
    float lanes[LANES], lowest = INFINITY;
    for (int64_t l = 0; l < LANES; l++)
        lanes[l] = INFINITY;
    for (int64_t k = 0; k + LANES <= count; k += LANES)
        for (int64_t l = 0; l < LANES; l++) {
            const float value = values[k + l] > bottom ? values[k + l] : INFINITY;
            lanes[l] = value < lanes[l] ? value : lanes[l];
        }
    for (int64_t l = 0; l < LANES; l++)
        lowest = smaller_f(lanes[l], lowest);
    for (int64_t k = count - count % LANES; k < count; k++)
        lowest = values[k] > bottom && values[k] < lowest ? values[k] : lowest;
    return lowest;
}

/* Looks at some samples that hold data; what is below `silence` counts as that. Fills lowest with the lowest
   value, the next higher one (the same where there is no other) and the share that have the lowest. */
KERNEL(lowest_samples, "rows u1|u2|f4[beams,:] samples, " MISSING ", float silence, out f8[3] lowest")
{
    const Missing missing = missing_at(&arguments[1], SIZE(0, 0), SIZE(0, 1));
    const LookedAt looked_at = look_at(SAMPLES(0), SIZE(0, 0), 0, LOOKED_AT, &missing);
    const float silence = (float)FLOAT(2);
    const float lowest = larger_f(lowest_over(-INFINITY, looked_at.values, looked_at.count), silence);
    const float higher = lowest_over(lowest, looked_at.values, looked_at.count);
    int64_t alike = 0;
    for (int64_t i = 0; i < looked_at.count; i++)
        alike += looked_at.values[i] <= lowest;
    double *out = ARRAY(double, 3);
    out[0] = looked_at.count > 0 ? lowest : 0.0;
    out[1] = looked_at.count == 0 ? 0.0 : higher < INFINITY ? higher : lowest;
    out[2] = looked_at.count > 0 ? (double)alike / (double)looked_at.count : 0.0;
}

/* Returns the threshold: the lowest amplitude over the bottom; 0 where there is none. */
static float threshold_over(float bottom, const float *values, int64_t count)
{
    double total = 0.0;
    int64_t over = 0;
    for (int64_t k = 0; k < count; k++) {
        total += values[k] > bottom ? values[k] : 0.0f;
        over += values[k] > bottom;
    }
    return over == 0 ? 0.0f : larger_f(lowest_over(bottom, values, count), (float)(FAINTEST * total / (double)over));
}

/* Adds to counts how many of `count` samples hold data, and how many of these are over the bottom. */
static void count_passing(const float *row, const bool *gaps, int64_t count, float bottom, int64_t *held, int64_t *over)
{
    int32_t lost = 0, passing = 0;
    if (gaps == NULL)
        for (int64_t j = 0; j < count; j++)
            passing += row[j] > bottom;
    else
        for (int64_t j = 0; j < count; j++) {
            lost += gaps[j];
            passing += (row[j] > bottom) & !gaps[j];
        }
    *held += count - lost;
    *over += passing;
}

/* Fills passing (blocks,) with the share of samples over the bottom in each block of `width` columns, less than 1. */
static void find_passing(const float *image, Missing missing, float bottom, int64_t width, double *passing)
{
    const int64_t samples = missing.samples, blocks = (samples + width - 1) / width;
    for (int64_t k = 0; k < blocks; k++) {
        const int64_t begin = k * width, count = smaller_i(width, samples - begin);
        int64_t held = 0, over = 0;
        for (int64_t b = 0; b < missing.beams; b++) {
            const bool *gaps = missing.marks == NULL ? NULL : missing.marks + b * missing.stride + begin;
            count_passing(image + b * samples + begin, gaps, count, bottom, &held, &over);
        }
        passing[k] = over > 0 ? (double)over / ((double)held + 1.0) : SILENT;
    }
}

/* Fills passing with the share of samples over the lowest amplitude in each block of `width` columns, and found with
   that amplitude and the threshold. */
KERNEL(find_threshold, "f4[beams,samples] image, " MISSING ", int width, out f8[blocks] passing, out f8[2] found")
{
    const float *image = ARRAY(const float, 0);
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1), width = larger_i(INT(2), 1);
    const float bottom = lowest_over(-INFINITY, image, beams * samples);
    if (SIZE(3, 0) != (samples + width - 1) / width)
        return;
    find_passing(image, missing_at(&arguments[1], beams, samples), bottom, width, ARRAY(double, 3));
    ARRAY(double, 4)[0] = bottom;
    ARRAY(double, 4)[1] = threshold_over(bottom, image, beams * samples);
}

/* Draws what is lowest in image anew, in place. rms, passing: of each block of `width` columns; number: of the ping. */
KERNEL(fill_below, "out f4[beams,samples] image, float bottom, int width, f8[blocks] rms, f8[blocks] passing, "
                   "f4[drawn] uniform, int number")
{
    const int64_t samples = SIZE(0, 1), width = larger_i(INT(2), 1), drawn = SIZE(5, 0);
    const float bottom = (float)FLOAT(1), *uniform = ARRAY(const float, 5);
    for (int64_t b = 0; b < SIZE(0, 0); b++) {
        float *row = ARRAY(float, 0) + b * samples;
        const int64_t first = begin_of(INT(6), b, drawn);
        for (int64_t k = 0; k < SIZE(3, 0); k++) {
            const double rms = ARRAY(const double, 3)[k], below = 1.0 - ARRAY(const double, 4)[k];
            for (int64_t j = k * width; j < smaller_i((k + 1) * width, samples); j++)
                if (row[j] <= bottom)
                    row[j] = (float)(rms * sqrt(-log(1.0 - uniform[(first + j) & (drawn - 1)] * below)));
        }
    }
}
