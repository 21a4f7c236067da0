/* Equalization by place: the mean around each place is brought to 1. The fan is parted into blocks; their means,
   interpolated in between, are the level. */

#include "ods/pipeline/equalize/by_range.h"
#include "ods/pipeline/image/gained_image.h"

/* A block is raised by so many times more than those beside it, at most: what is darker is a shadow. */
#define BESIDE 1.4f
/* Blocks along the range to either side whose median a block's mean is compared to. */
#define AROUND 2

/* How the fan is parted: first beam and first column of each block. */
typedef struct {
    const int64_t *beams, *columns;
    int64_t in_beams, in_range;
} Blocks;

/* Returns where block k ends. */
static inline int64_t stop_of(const int64_t *first, int64_t k, int64_t blocks, int64_t whole)
{
    return k + 1 < blocks ? first[k + 1] : whole;
}

/* Fills means (beam blocks, range blocks) with the mean of the image over each block. */
static void block_means(GainedImage image, Blocks blocks, float *means)
{
    float *restrict sums = SCRATCH(float, image.samples);
    for (int64_t p = 0; p < blocks.in_beams; p++) {
        const int64_t first = blocks.beams[p], stop = stop_of(blocks.beams, p, blocks.in_beams, image.beams);
        memset(sums, 0, (size_t)image.samples * sizeof *sums);
        for (int64_t b = first; b < stop; b++)
            add_row(image, b, sums);
        for (int64_t q = 0; q < blocks.in_range; q++) {
            const int64_t begin = blocks.columns[q], end = stop_of(blocks.columns, q, blocks.in_range, image.samples);
            float total = 0.0f;
            for (int64_t j = begin; j < end; j++)
                total += sums[j];
            means[p * blocks.in_range + q] = total / (float)((stop - first) * (end - begin));
        }
    }
}

/* Limits the gain of the blocks at one range to BESIDE times the lower of those beside each; infinite ones to 1.

   gain (beam blocks,): `step` elements apart; before (beam blocks,): work space. */
static void keep_shadows_dark(float *gain, int64_t blocks, int64_t step, float *before)
{
    for (int64_t p = 0; p < blocks; p++)
        before[p] = gain[p * step];
    for (int64_t p = 0; p < blocks; p++) {
        float limited = smaller_f(BESIDE * before[larger_i(0, p - 1)], before[p]);
        limited = smaller_f(BESIDE * before[smaller_i(p + 1, blocks - 1)], limited);
        gain[p * step] = limited < INFINITY ? limited : 1.0f;
    }
}

/* Fills gain with 1 / means (beam blocks, range blocks), 1 where there is no mean.

   A mean is limited to a factor of guard of the median of five blocks along the range: what lasts there is a beam's
   gain, what does not is an object, however wide, or the dark that the equalization per range leaves beside it. */
static void block_gains(const float *means, Blocks blocks, float guard, float *gain)
{
    const int64_t count = blocks.in_range;
    float work[2 * AROUND + 1];
    for (int64_t p = 0; p < blocks.in_beams; p++)
        for (int64_t q = 0; q < count; q++) {
            const float *mean = means + p * count;
            const int64_t first = larger_i(0, q - AROUND), stop = smaller_i(count, q + AROUND + 1);
            const float around = sorted_middle(mean + first, stop - first, work);
            const float level = smaller_f(around * guard, larger_f(around / guard, mean[q]));
            gain[p * count + q] = level > 0.0f ? 1.0f / level : INFINITY;
        }
    float *before = SCRATCH(float, blocks.in_beams);
    for (int64_t q = 0; q < count; q++)
        keep_shadows_dark(gain + q, blocks.in_beams, count, before);
}

/* Fills rows (beam blocks, samples) with gain (beam blocks, range blocks) interpolated along the range, times the one
   that the samples have already.

   before (samples,): the last block whose middle is not behind the column; share: how far it is to the next one's. */
static void interpolate_columns(const float *gain, Blocks blocks, const int64_t *before, const float *restrict share,
                                const float *restrict others, int64_t samples, float *rows)
{
    const int64_t last = blocks.in_range - 1;
    int64_t begin = 0;
    for (int64_t q = 0; q <= last; q++) {
        int64_t end = begin;
        while (end < samples && before[end] == q)
            end++;
        for (int64_t p = 0; p < blocks.in_beams; p++) {
            const float near = gain[p * blocks.in_range + q];
            const float step = gain[p * blocks.in_range + smaller_i(q + 1, last)] - near;
            float *restrict row = rows + p * samples;
            for (int64_t j = begin; j < end; j++)
                row[j] = (near + share[j] * step) * others[j];
        }
        begin = end;
    }
}

/* Fills rows with the gain that brings the image's mean around each place to 1. */
KERNEL(local_gain, GAINED_IMAGE ", i8[beam_blocks] first_beam, i8[range_blocks] first_column, i8[samples] before, "
                                "f4[samples] between, float guard, out f4[beam_blocks,samples] rows")
{
    const GainedImage image = gained_image_at(arguments);
    arguments += arguments_of(GAINED_IMAGE);
    const Blocks blocks = {ARRAY(const int64_t, 0), ARRAY(const int64_t, 1), SIZE(0, 0), SIZE(1, 0)};
    float *means = SCRATCH(float, blocks.in_beams * blocks.in_range);
    float *gain = SCRATCH(float, blocks.in_beams * blocks.in_range);
    block_means(image, blocks, means);
    block_gains(means, blocks, (float)FLOAT(4), gain);
    interpolate_columns(gain, blocks, ARRAY(const int64_t, 2), ARRAY(const float, 3), image.gain, image.samples,
                        ARRAY(float, 5));
}
