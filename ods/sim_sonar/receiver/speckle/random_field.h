/* Random numbers as functions of what they are for (see random_field.py): 32-bit hashes, and normal numbers of them. */

#ifndef ODS_RANDOM_FIELD_H
#define ODS_RANDOM_FIELD_H

#include "kernel.h"

/* Returns 32 well mixed bits of a 32-bit key (a bijection: xor-shifts and odd multipliers). */
static inline uint32_t hash32(uint32_t key)
{
    uint32_t bits = key ^ (key >> 16);
    bits *= 0x21F0AAADu;
    bits ^= bits >> 15;
    bits *= 0x735A2D97u;
    return bits ^ (bits >> 15);
}

/* `normal_table` in a signature: one argument. */
#define NORMAL_TABLE "f4[65536] normal"

/* Sets `out` to the normal numbers of hashes: each makes two look-ups of 16 bits. */
static inline void normals_of(const uint32_t *restrict bits, const float *restrict table, int64_t count,
                              float *restrict out)
{
    for (int64_t j = 0; j < count; j++)
        out[j] = table[bits[j] & 0xFFFFu] + table[bits[j] >> 16];
}

/* Adds `source` times `factor` to `target`. */
static inline void add_times(float *restrict target, float factor, const float *restrict source, int64_t count)
{
    for (int64_t j = 0; j < count; j++)
        target[j] += factor * source[j];
}

#endif
