/* Range ends: a filter sees the image mirrored there. Replicated ends would repeat one speckle sample into an echo. */

#ifndef ODS_PADDING_H
#define ODS_PADDING_H

#include "kernel.h"

/* Returns where a row of `samples` mirrored about its end samples (d c b | a b c d | c b a) has column `index`. */
static inline int64_t mirrored(int64_t index, int64_t samples)
{
    const int64_t period = 2 * (samples - 1);
    int64_t folded = index < 0 ? -index : index;
    if (samples == 1)
        return 0;
    if (folded > period)
        folded %= period;
    return folded < samples ? folded : period - folded;
}

/* Mirrors padded[half : half + samples] into the `half` cells before and after it. */
static inline void mirror_ends(float *padded, int64_t half, int64_t samples)
{
    for (int64_t i = 1; i <= half; i++) {
        padded[half - i] = padded[half + mirrored(i, samples)];
        padded[half + samples - 1 + i] = padded[half + mirrored(samples - 1 + i, samples)];
    }
}

#endif
