/* What stands in an image where no data are, so that no stage has to know of them.

   Zeros would be dark places to every equalizer and edges to every filter. So each sample without data gets what an
   image without an echo would show there: mostly the mean of its neighbours along the beam where there are any, else
   that of the two beams beside it, else speckle at the level of its range and its beam. Statistics of the image then
   stay what they are where data are. Before an image is searched for echoes these cells are set to 0, which detection
   takes for no data, so no echo is found or measured in them. Only gaps so short that they are filled by their
   neighbours on both sides stay as they are filled, such as a single dead beam, which both its neighbours overlap: an
   echo does not fall to pieces there. */

#include "ods/pipeline/equalize/by_range.h"
#include "ods/pipeline/image/missing/fill.h"

/* The beams beside, or the level around, weigh as much as so many of them: one crest beside a gap must not be repeated
   in it. */
#define PRIOR 2.0f
/* The level of the ranges around weighs as much as so many beams, */
#define BEAMS_AROUND 4.0f
/* and that of the other beams as much as so many samples of a beam. */
#define COLUMNS_OF_OTHERS 64.0f
/* Largest factor between beams that is believed. */
#define MOST_GAIN 4.0f

/* Fills level and count (samples,) with sum and number over the beams of what holds data. */
static void sum_data(const float *image, Missing missing, float *restrict level, float *restrict count)
{
    const int64_t samples = missing.samples;
    memset(level, 0, (size_t)samples * sizeof *level);
    memset(count, 0, (size_t)samples * sizeof *count);
    for (int64_t b = 0; b < missing.beams; b++) {
        const float *restrict row = image + b * samples;
        const bool *restrict gaps = missing.marks + b * missing.stride;
        for (int64_t j = 0; j < samples; j++) {
            level[j] += gaps[j] ? 0.0f : row[j];
            count[j] += gaps[j] ? 0.0f : 1.0f;
        }
    }
}

/* Returns the mean of columns `begin` to `stop` - 1; `otherwise` where they hold no data. */
static float mean_of_columns(const float *level, const float *count, int64_t begin, int64_t stop, float otherwise)
{
    float total = 0.0f, cells = 0.0f;
    for (int64_t j = begin; j < stop; j++) {
        total += level[j];
        cells += count[j];
    }
    return cells > 0.0f ? total / cells : otherwise;
}

/* Fills level (samples,) with the mean over the beams of what holds data, drawn to that of the ranges around. What
   stands before the first block that has any is that block's. It is limited by a guard, as `mean_range` does: an echo in
   the few beams that hold data is no level. */
static void levels_of_data(const float *image, Missing missing, float guard, int64_t window, float *level)
{
    const int64_t samples = missing.samples;
    float *count = SCRATCH(float, samples);
    int64_t first = 0;
    sum_data(image, missing, level, count);
    while (first < samples && count[first] == 0.0f)
        first++;
    first -= first % SAMPLES_OF_BLOCK;
    float around = mean_of_columns(level, count, first, smaller_i(first + SAMPLES_OF_BLOCK, samples), -1.0f);
    for (int64_t begin = 0; begin < samples; begin += SAMPLES_OF_BLOCK) {
        const int64_t stop = smaller_i(begin + SAMPLES_OF_BLOCK, samples);
        around = mean_of_columns(level, count, begin, stop, around);
        for (int64_t j = begin; j < stop; j++)
            level[j] = (level[j] + BEAMS_AROUND * around) / (count[j] + BEAMS_AROUND);
    }
    limit_levels(level, samples, guard, blocks_around(window));
}

/* Returns how much louder than the others a beam is, by what holds data of it. */
static float gain_of(const float *row, const bool *gaps, const float *level, int64_t samples)
{
    float own = 0.0f, others = 0.0f, all = 0.0f;
    for (int64_t j = 0; j < samples; j++) {
        own += gaps[j] ? 0.0f : row[j];
        others += gaps[j] ? 0.0f : level[j];
        all += level[j];
    }
    const float prior = COLUMNS_OF_OTHERS * all / (float)samples;
    if (others + prior <= 0.0f)
        return 1.0f;
    return smaller_f(larger_f((own + prior) / (others + prior), 1.0f / MOST_GAIN), MOST_GAIN);
}

/* Fills sum (samples,) with that of the cells of `values` around each; values: with NEIGHBOURS cells before and behind. */
static void sum_around(const float *restrict values, int64_t samples, float *restrict sum)
{
    memset(sum, 0, (size_t)samples * sizeof *sum);
    for (int64_t k = 0; k <= 2 * NEIGHBOURS; k++)
        for (int64_t j = 0; j < samples; j++)
            sum[j] += values[j + k];
}

/* Fills found and count (samples,) with sum and number of the cells around that hold data; held: work space, of which
   the first and last NEIGHBOURS cells are 0. */
static void sums_around(const float *row, const bool *gaps, int64_t samples, float *held, float *found, float *count)
{
    float *restrict inner = held + NEIGHBOURS;
    for (int64_t j = 0; j < samples; j++)
        inner[j] = gaps[j] ? 0.0f : 1.0f;
    sum_around(held, samples, count);
    for (int64_t j = 0; j < samples; j++)
        inner[j] = gaps[j] ? 0.0f : row[j];
    sum_around(held, samples, found);
}

/* Fills the missing cells of image, in place; number: of the ping. */
KERNEL(fill_gaps, "out f4[beams,samples] image, b1[beams,samples] missing, f4[drawn] speckle, int number, float guard, "
                  "int window")
{
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1), drawn = SIZE(2, 0);
    const Missing missing = missing_at(&arguments[1], beams, samples);
    const float *speckle = ARRAY(const float, 2);
    float *level = SCRATCH(float, samples), *found = SCRATCH(float, samples), *count = SCRATCH(float, samples);
    float *held = ZEROS(float, samples + 2 * NEIGHBOURS);
    levels_of_data(ARRAY(float, 0), missing, (float)FLOAT(4), INT(5), level);
    for (int64_t b = 0; b < beams; b++) {
        float *row = ARRAY(float, 0) + b * samples;
        const bool *gaps = missing.marks + b * samples;
        if (next_gap(gaps, 0, samples).begin == samples)
            continue;
        const float gain = gain_of(row, gaps, level, samples);
        const int64_t begin = begin_of(INT(3), b, drawn);
        sums_around(row, gaps, samples, held, found, count);
        for (int64_t j = 0; j < samples; j++)
            if (gaps[j]) {
                const float prior = is_one_beam_wide(missing, b, j)
                                        ? 0.5f * (row[j - samples] + row[j + samples])
                                        : gain * level[j] * speckle[(begin + j) & (drawn - 1)];
                row[j] = (found[j] + PRIOR * prior) / (count[j] + PRIOR);
            }
    }
}

/* Adds noise of a count to amplitudes of linear counts, in place. Some fall below 0, which keeps the mean. */
KERNEL(dither, "out f4[beams,samples] image, f4[drawn] noise, int number")
{
    const int64_t samples = SIZE(0, 1), drawn = SIZE(1, 0);
    for (int64_t b = 0; b < SIZE(0, 0); b++) {
        float *restrict row = ARRAY(float, 0) + b * samples;
        int64_t begin = begin_of(INT(2), b, drawn);
        for (int64_t done = 0; done < samples; begin = 0) {
            const float *restrict noise = ARRAY(const float, 1) + begin;
            const int64_t count = smaller_i(samples - done, drawn - begin);
            for (int64_t j = 0; j < count; j++)
                row[done + j] += noise[j];
            done += count;
        }
    }
}

/* Sets the missing cells of image to 0, but for gaps that are bridged. */
KERNEL(blank_gaps, "out f4[beams,samples] image, b1[beams,samples] missing")
{
    const int64_t beams = SIZE(0, 0), samples = SIZE(0, 1);
    const Missing missing = missing_at(&arguments[1], beams, samples);
    for (int64_t b = 0; b < beams; b++) {
        const bool *gaps = missing.marks + b * samples;
        for (Span gap = next_gap(gaps, 0, samples); gap.begin < samples; gap = next_gap(gaps, gap.stop, samples)) {
            if (is_bridged(gap) && gap.begin > 0 && gap.stop < samples)
                continue;
            for (int64_t j = gap.begin; j < gap.stop; j++)
                if (!is_one_beam_wide(missing, b, j))
                    ARRAY(float, 0)[b * samples + j] = 0.0f;
        }
    }
}
