/* Where among the drawn numbers a beam begins, and how long a gap its neighbours fill (fill.py). */

#ifndef ODS_FILL_H
#define ODS_FILL_H

#include "kernel.h"
#include "ods/pipeline/image/missing/no_data.h"

/* Samples to either side whose mean fills a gap. */
#define NEIGHBOURS 4

/* Whether a gap is so short that its neighbours fill it from both sides. */
static inline bool is_bridged(Span gap) { return gap.stop - gap.begin <= 2 * NEIGHBOURS; }

/* Returns where among `drawn` numbers (a power of 2) a beam begins: anywhere, but always the same for the same ping. */
static inline int64_t begin_of(int64_t number, int64_t beam, int64_t drawn)
{
    uint32_t mixed = (uint32_t)number * 0x9E3779B1u + (uint32_t)beam * 0x85EBCA77u + 0x165667B1u;
    mixed = (mixed ^ (mixed >> 15)) * 0x2C1B3C6Du;
    return (int64_t)(mixed ^ (mixed >> 13)) & (drawn - 1);
}

#endif
