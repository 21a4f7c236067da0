/* Amplitudes to 8-bit logarithmic samples. */

#include "kernel.h"

#define HIGHEST 255

/* The highest level whose threshold an amplitude, 0 or more, reaches. A float's upper bits give its level or one below
   (`table`, by the bits that are left after a shift); the thresholds above that decide which. */
LONG_KERNEL(look_up_levels, "f4[n] amplitude, u1[:] table, f4[256] thresholds, int shift, out u1[n] samples")
{
    const float *restrict amplitude = ARRAY(float, 0), *restrict thresholds = ARRAY(float, 2);
    const uint8_t *restrict table = ARRAY(uint8_t, 1);
    const uint32_t last = (uint32_t)(SIZE(1, 0) - 1), shift = (uint32_t)INT(3);
    uint8_t *restrict samples = ARRAY(uint8_t, 4);
    for (int64_t j = 0; j < SIZE(0, 0); j++) {
        uint32_t bits;
        memcpy(&bits, &amplitude[j], sizeof bits);
        const uint32_t cell = bits >> shift;
        uint32_t level = table[cell < last ? cell : last];
        while (level < HIGHEST && amplitude[j] >= thresholds[level])
            level++;
        samples[j] = (uint8_t)level;
    }
}
