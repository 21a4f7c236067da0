/* Blocks of samples that are summed up in registers: written out, since compilers keep sums over a window of any length
   in memory. */

#ifndef ODS_LANES_H
#define ODS_LANES_H

#include "kernel.h"

/* Numbers that a processor adds up at once. */
typedef float Lanes __attribute__((vector_size(32), aligned(4), may_alias));
#define LANES 8

/* Lanes and samples of a block. The last block of a row reaches beyond it: what is read has BLOCK more elements. */
#define LANES_OF_BLOCK 4
#define BLOCK (LANES_OF_BLOCK * LANES)

static inline Lanes load(const float *from)
{
    return *(const Lanes *)from;
}

/* Stores a block, or what of it belongs to the row, which ends after `left` samples. */
static inline void store_block(const Lanes *block, int64_t left, float *restrict target)
{
    if (left >= BLOCK)
        memcpy(target, block, BLOCK * sizeof(float));
    else
        memcpy(target, block, (size_t)left * sizeof(float));
}

#endif
