/* Blocks of samples that are summed up in registers: written out, since compilers keep sums over a window of any length
   in memory. */

#ifndef ODS_LANES_H
#define ODS_LANES_H

#include "kernel.h"

/* Numbers that a processor adds up at once. */
typedef float Lanes __attribute__((vector_size(32), aligned(4), may_alias));
#define LANES 8
typedef int32_t Bits __attribute__((vector_size(32))); /* of Lanes */

/* Lanes and samples of a block. The last block of a row reaches beyond it: what is read has BLOCK more elements. */
#define LANES_OF_BLOCK 4
#define BLOCK (LANES_OF_BLOCK * LANES)

/* Rows that are worked on at once: what is made of one does not wait for another. */
#define ROWS 4

/* Samples of which what is made in between stays in the nearest cache. */
#define COLUMNS 256

static inline Lanes load(const float *from)
{
    return *(const Lanes *)from;
}

static inline void store(Lanes lanes, float *to)
{
    *(Lanes *)to = lanes;
}

/* Returns which is higher, lane by lane. */
static inline Lanes higher(Lanes a, Lanes b)
{
    const Bits above = a > b;
    return (Lanes)((above & (Bits)a) | (~above & (Bits)b));
}

/* Returns the highest lane. */
static inline float highest_lane(Lanes lanes)
{
    lanes = higher(lanes, __builtin_shuffle(lanes, (Bits){4, 5, 6, 7, 0, 1, 2, 3}));
    lanes = higher(lanes, __builtin_shuffle(lanes, (Bits){2, 3, 0, 1, 6, 7, 4, 5}));
    lanes = higher(lanes, __builtin_shuffle(lanes, (Bits){1, 0, 3, 2, 5, 4, 7, 6}));
    return lanes[0];
}

/* Returns the sum of the lanes. */
static inline float sum_of_lanes(Lanes lanes)
{
    lanes += __builtin_shuffle(lanes, (Bits){4, 5, 6, 7, 0, 1, 2, 3});
    lanes += __builtin_shuffle(lanes, (Bits){2, 3, 0, 1, 6, 7, 4, 5});
    return lanes[0] + lanes[1];
}

/* Stores a block, or what of it belongs to the row, which ends after `left` samples. */
static inline void store_block(const Lanes *block, int64_t left, float *restrict target)
{
    if (left >= BLOCK) {
        for (int64_t i = 0; i < LANES_OF_BLOCK; i++)
            store(block[i], target + i * LANES);
        return;
    }
    float whole[BLOCK]; /* a copy, so that the block itself may stay in registers */
    for (int64_t i = 0; i < LANES_OF_BLOCK; i++)
        store(block[i], whole + i * LANES);
    memcpy(target, whole, (size_t)left * sizeof(float));
}

#endif
