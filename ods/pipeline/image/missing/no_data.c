/* Samples that hold no data, by what can be seen in the samples themselves.

   A beam that is cut short is padded with zeros, and a dead one is all zeros. Zeros are data, too, where the water is so
   quiet that most samples are less than one count. So zeros up to a beam's end count as no data only where the beam was
   loud just before, or where the other beams are not silent at those ranges. Zeros strewn over a loud image hold no data
   either: speckle is hardly ever that dark. */

#include "ods/pipeline/image/samples/looked_at.h"

/* Samples at a beam's end that are zero before it is looked at. */
#define TAIL (SAMPLES_OF_BLOCK / 2)
/* A block of a beam is loud where no more than this share of it is zero. */
#define LOUD 0.5f
/* Blocks before a run of zeros of which three in four have to be loud. */
#define BEFORE 8
/* Share of zeros among some samples from which on the image is looked at as a whole. */
#define STREWN 0.03
/* By so many samples at least the mean amplitude of a block is known. */
#define FEWEST 6
/* Of the mean amplitude of the samples that are not zero, and the share of them that is as faint: of speckle, 5 %.
   Where none is, zeros stand for what is below a threshold of the sonar's (threshold.py). */
#define FAINT 0.25f
#define FAINT_SHARE 0.01
/* Logarithm of how improbable zeros have to be where other beams are not silent; each block counts for 1 at most. */
#define EVIDENCE 12.0

/* Returns the share of zeros among some samples from column `first` on. */
static double share_of_zeros_in(Samples frame, int64_t beams, int64_t first)
{
    const LookedAt looked_at = look_at(frame, beams, first, LOOKED_AT, NULL);
    int64_t zeros = 0;
    for (int64_t i = 0; i < looked_at.count; i++)
        zeros += looked_at.values[i] == 0.0f;
    return (double)zeros / (double)larger_i(looked_at.count, 1);
}

KERNEL_FLOAT(share_of_zeros, "rows u1|u2|f4[beams,:] frame, int first")
{
    return share_of_zeros_in(SAMPLES(0), SIZE(0, 0), larger_i(INT(1), 0));
}

/* Tells an image from a drop-out, in which all samples from column `first` on are alike. */
KERNEL_BOOL(shows_something, "rows u1|u2|f4[beams,:] frame, int first")
{
    const int64_t first = larger_i(INT(1), 0), count = SIZE(0, 1) - first;
    float *row = SCRATCH(float, larger_i(count, 1)), value = 0.0f;
    for (int64_t b = 0; b < SIZE(0, 0) && count > 0; b++) {
        int64_t others = 0;
        load_samples(SAMPLES(0), b, first, 1, count, row);
        value = b == 0 ? row[0] : value;
        for (int64_t j = 0; j < count; j++)
            others += row[j] != value;
        if (others > 0)
            return true;
    }
    return false;
}

/* ---------------------------------------------------------------- zeros at the ends of beams */

/* Returns where the zeros at a row's end begin. */
static int64_t begin_of_tail(const float *row, int64_t samples)
{
    while (samples > 0 && row[samples - 1] == 0.0f)
        samples--;
    return samples;
}

/* Whether any beam ends in zeros. */
static bool any_silent_tail(Samples frame, int64_t beams, int64_t first)
{
    const int64_t begin = larger_i(first, frame.samples - TAIL);
    float tail[TAIL];
    for (int64_t b = 0; b < beams; b++) {
        load_samples(frame, b, begin, 1, frame.samples - begin, tail);
        if (begin_of_tail(tail, frame.samples - begin) == 0)
            return true;
    }
    return false;
}

static float share_of_zeros_of(const float *part, int64_t size)
{
    int32_t count = 0;
    for (int64_t j = 0; j < size; j++)
        count += part[j] == 0.0f;
    return (float)count / (float)size;
}

/* Fills zeros (blocks,) with the share of zeros of each block of the row. */
static void shares_of_zeros(const float *row, int64_t samples, float *zeros)
{
    const int64_t blocks = samples / SAMPLES_OF_BLOCK;
    for (int64_t k = 0; k < blocks; k++)
        zeros[k] = share_of_zeros_of(row + k * SAMPLES_OF_BLOCK, SAMPLES_OF_BLOCK);
    if (blocks * SAMPLES_OF_BLOCK < samples)
        zeros[blocks] = share_of_zeros_of(row + blocks * SAMPLES_OF_BLOCK, samples - blocks * SAMPLES_OF_BLOCK);
}

/* Whether a beam was loud before the zeros at its end. */
static bool was_loud(const float *zeros, int64_t tail)
{
    const int64_t last = tail / SAMPLES_OF_BLOCK, begin = larger_i(0, last - BEFORE);
    int64_t loud = 0;
    for (int64_t k = begin; k < last; k++)
        loud += zeros[k] <= LOUD;
    return last > begin && 4 * loud >= 3 * (last - begin);
}

/* Whether zeros from `tail` on are no chance, as often as all beams are zero there; silent (blocks,). */
static bool is_improbable(const float *silent, int64_t blocks, int64_t tail)
{
    const int64_t begin = (tail + SAMPLES_OF_BLOCK - 1) / SAMPLES_OF_BLOCK;
    double evidence = 0.0;
    for (int64_t k = begin; k < blocks; k++)
        evidence += smaller(1.0, -SAMPLES_OF_BLOCK * log(larger(silent[k], 1e-6)));
    return evidence >= larger(EVIDENCE, 0.5 * (double)(blocks - begin));
}

/* Fills starts (beams,) with the column from which on each beam holds no data: the number of columns where it is whole.
   Tells whether any beam is not. */
static bool find_starts_of_gaps(Samples frame, int64_t beams, int64_t first, int64_t *starts)
{
    const int64_t samples = frame.samples - first, blocks = (samples + SAMPLES_OF_BLOCK - 1) / SAMPLES_OF_BLOCK;
    float *row = SCRATCH(float, samples), *zeros = SCRATCH(float, beams * blocks), *silent = ZEROS(float, blocks);
    bool any = false;
    for (int64_t b = 0; b < beams; b++) {
        load_samples(frame, b, first, 1, samples, row);
        starts[b] = begin_of_tail(row, samples);
        shares_of_zeros(row, samples, zeros + b * blocks);
        for (int64_t k = 0; k < blocks; k++)
            silent[k] += zeros[b * blocks + k] / (float)beams;
    }
    for (int64_t b = 0; b < beams; b++) {
        const int64_t tail = starts[b];
        const bool lost = samples - tail >= TAIL && (was_loud(zeros + b * blocks, tail) || is_improbable(silent, blocks, tail));
        starts[b] = lost ? first + tail : frame.samples;
        any |= lost;
    }
    return any;
}

/* ---------------------------------------------------------------- zeros strewn over an image */

/* What its blocks are. */
typedef struct {
    int64_t blocks, loud, strewn; /* of the loud ones, those with several zeros; in these */
    int64_t faint, others;        /* samples that are faint, and those that are not 0 */
} Strewn;

static void look_at_block(const float *part, float loud, Strewn *seen)
{
    float total = 0.0f;
    int32_t count = 0, faint = 0;
    for (int64_t j = 0; j < SAMPLES_OF_BLOCK; j++) {
        total += part[j];
        count += part[j] != 0.0f;
    }
    seen->blocks++;
    if (count < FEWEST || !(total >= loud * (float)count))
        return;
    seen->loud++;
    if (SAMPLES_OF_BLOCK - count < 3)
        return;
    for (int64_t j = 0; j < SAMPLES_OF_BLOCK; j++)
        faint += part[j] > 0.0f && part[j] <= FAINT * total / (float)count;
    seen->strewn++;
    seen->others += count;
    seen->faint += faint;
}

/* Whether a quarter of all blocks are loud, and most of those have several zeros, but faint samples, too. */
static bool is_strewn(Samples frame, int64_t beams, int64_t first, float loud)
{
    const int64_t samples = frame.samples - first;
    float *row = SCRATCH(float, samples);
    Strewn seen = {0};
    for (int64_t b = 0; b < beams; b++) {
        load_samples(frame, b, first, 1, samples, row);
        for (int64_t begin = 0; begin + SAMPLES_OF_BLOCK <= samples; begin += SAMPLES_OF_BLOCK)
            look_at_block(row + begin, loud, &seen);
    }
    return 4 * seen.loud >= seen.blocks && seen.blocks > 0 && 2 * seen.strewn > seen.loud
           && (double)seen.faint > FAINT_SHARE * (double)seen.others;
}

enum { AT_ENDS = 1, STREWN_ABOUT = 2 };

/* Returns AT_ENDS if beams end in zeros that are no data, from column starts[b] on, plus STREWN_ABOUT if zeros strewn over the image
   are none. Looked at is what lies from column `first` on; loud: mean of a block that is clearly above the lowest count. */
KERNEL_INT(find_gaps, "rows u1|u2|f4[beams,:] frame, int first, float loud, out i8[beams] starts")
{
    const Samples frame = SAMPLES(0);
    const int64_t beams = SIZE(0, 0), first = INT(1);
    int64_t found = 0;
    if (first < 0 || first >= frame.samples)
        return 0;
    if (any_silent_tail(frame, beams, first) && find_starts_of_gaps(frame, beams, first, ARRAY(int64_t, 3)))
        found += AT_ENDS;
    if (share_of_zeros_in(frame, beams, first) > STREWN && is_strewn(frame, beams, first, (float)FLOAT(2)))
        found += STREWN_ABOUT;
    return found;
}
