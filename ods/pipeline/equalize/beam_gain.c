/* Equalization by beam: beams of different gain are brought to the same level [SSIE, Image processing, stage 1].

   A beam's gain is what nearly all parts of its range agree on, each compared to the median of all beams there. */

#include "ods/pipeline/filter/rows/halving.h"
#include "ods/pipeline/image/gained_image.h"

/* Parts of the range, at most, */
#define MOST_PARTS 25
/* and samples of a part, at least. */
#define SHORTEST 16
/* Lowest and highest parts of a beam that do not count; but as many nearest ones always do where a beam is dark. */
#define LEFT_OUT 2
/* Gains of less than half a decibel are left to the other equalizers. */
#define LEAST 1.06f

/* Fills means (parts, beams) with the mean of each part of the range. */
static void part_means(GainedImage image, int64_t parts, float *means)
{
    float *row = SCRATCH(float, image.samples);
    for (int64_t b = 0; b < image.beams; b++) {
        load_row(image, b, row);
        for (int64_t k = 0; k < parts; k++) {
            const int64_t begin = k * image.samples / parts, stop = (k + 1) * image.samples / parts;
            float total = 0.0f;
            for (int64_t j = begin; j < stop; j++)
                total += row[j];
            means[k * image.beams + b] = total / (float)(stop - begin);
        }
    }
}

/* Returns the median of values, none of them negative: it is at most twice the mean. */
static float median_of(const float *values, int64_t count)
{
    float total = 0.0f;
    for (int64_t i = 0; i < count; i++)
        total += values[i];
    return median_between(0.0f, 2.0f * total / (float)count, values, count);
}

/* Sorts part (beams,) into `kept` rows of the lowest values, rising, and of the highest ones, falling; part is lost.

   falling (beams,): work space. */
static void keep_extremes(float *restrict part, int64_t beams, int64_t kept, float *restrict falling, float *lowest,
                          float *highest)
{
    memcpy(falling, part, (size_t)beams * sizeof(float));
    for (int64_t i = 0; i < kept; i++) {
        float *restrict low = lowest + i * beams, *restrict high = highest + i * beams;
        for (int64_t b = 0; b < beams; b++) {
            const float lower = smaller_f(part[b], low[b]), higher = larger_f(falling[b], high[b]);
            part[b] = part[b] < low[b] ? low[b] : part[b];
            falling[b] = falling[b] > high[b] ? high[b] : falling[b];
            low[b] = lower;
            high[b] = higher;
        }
    }
}

/* Fills low and high (beams,) with the least and the largest level of each beam's parts that count.

   means: (parts, beams), which become multiples of each part's median; parts of zeros are left out. */
static void bounds_of_levels(float *means, int64_t parts, int64_t beams, float *low, float *high)
{
    const int64_t left_out = smaller_i(LEFT_OUT, (parts - 1) / 2), kept = left_out + 1;
    float *lowest = SCRATCH(float, kept * beams), *highest = ZEROS(float, kept * beams);
    float *nearest = ZEROS(float, beams), *falling = SCRATCH(float, beams);
    for (int64_t k = 0; k < kept * beams; k++)
        lowest[k] = INFINITY;
    for (int64_t k = 0; k < parts; k++) {
        float *part = means + k * beams;
        const float around = median_of(part, beams);
        if (!(around > 0.0f))
            continue;
        for (int64_t b = 0; b < beams; b++)
            part[b] /= around;
        if (k < LEFT_OUT)
            for (int64_t b = 0; b < beams; b++)
                nearest[b] = larger_f(part[b], nearest[b]);
        keep_extremes(part, beams, kept, falling, lowest, highest);
    }
    for (int64_t b = 0; b < beams; b++) {
        low[b] = lowest[left_out * beams + b] < INFINITY ? lowest[left_out * beams + b] : 0.0f;
        high[b] = larger_f(nearest[b], highest[left_out * beams + b]);
    }
}

/* Returns what brings a beam to the common level; its parts are of levels low to high, usual * usual apart at most
   within a beam that nothing is in. */
static float gain_of_beam(float low, float high, float middle, float common, float usual, float limit)
{
    float level = common;
    if (low > common)
        level = smaller_f(middle, low * usual);
    else if (0.0f < high && high < common)
        level = larger_f(middle, high / usual);
    if (!(level > 0.0f && common > 0.0f))
        return 1.0f;
    return smaller_f(limit, larger_f(1.0f / limit, common / level));
}

/* Fills gain with what brings the beams to one level, up to a factor of limit; returns whether that is to be done. */
KERNEL_BOOL(measure_beam_gain, GAINED_IMAGE ", float limit, out f4[beams] gain")
{
    const GainedImage image = gained_image_at(arguments);
    const int64_t beams = image.beams, parts = larger_i(1, smaller_i(MOST_PARTS, image.samples / SHORTEST));
    const float limit = (float)FLOAT(arguments_of(GAINED_IMAGE));
    float *gain = ARRAY(float, arguments_of(GAINED_IMAGE) + 1), *means = SCRATCH(float, parts * beams);
    float *low = SCRATCH(float, beams), *high = SCRATCH(float, beams);
    float *middle = SCRATCH(float, beams), *spread = SCRATCH(float, beams);
    part_means(image, parts, means);
    bounds_of_levels(means, parts, beams, low, high);
    for (int64_t b = 0; b < beams; b++) {
        middle[b] = sqrtf(low[b] * high[b]);
        spread[b] = low[b] > 0.0f ? sqrtf(high[b] / low[b]) : 1.0f;
    }
    const float common = median_of(middle, beams), usual = median_of(spread, beams);
    float least = 1.0f, most = 1.0f;
    for (int64_t b = 0; b < beams; b++) {
        gain[b] = gain_of_beam(low[b], high[b], middle[b], common, usual, limit);
        least = smaller_f(gain[b], least);
        most = larger_f(gain[b], most);
    }
    return most > LEAST || least < 1.0f / LEAST;
}
