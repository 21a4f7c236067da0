/* Levels of amplitudes. */

#ifndef ODS_DECIBELS_H
#define ODS_DECIBELS_H

#include "kernel.h"

#define DB_OF_E ((float)(20.0 / log(10.0)))
#define DB_OF_2 ((float)(20.0 * log10(2.0)))
#define SQRT_HALF_BITS 0x3f3504f3

/* Returns 20 log10 of a number above 0, to 1e-7 of the logarithm: of x = m 2^e, m about 1, by the series of
   log m = 2 artanh((m - 1) / (m + 1)). */
static inline float decibels(float x)
{
    int32_t bits;
    float m;
    memcpy(&bits, &x, sizeof bits);
    const int32_t e = (bits - SQRT_HALF_BITS) >> 23; /* m from sqrt(1/2) to sqrt(2) */
    bits -= e * (1 << 23);
    memcpy(&m, &bits, sizeof m);
    const float s = (m - 1.0f) / (m + 1.0f), z = s * s;
    const float log_m = 2.0f * s * (1.0f + z * (1.0f / 3.0f + z * (1.0f / 5.0f + z * (1.0f / 7.0f + z / 9.0f))));
    return DB_OF_2 * (float)e + DB_OF_E * log_m;
}

#endif
