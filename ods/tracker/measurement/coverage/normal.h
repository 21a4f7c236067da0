/* The standard normal distribution. */

#ifndef ODS_NORMAL_H
#define ODS_NORMAL_H

#include "kernel.h"

/* Returns the probability of less than `deviate` standard deviations. */
static inline double normal_below(double deviate)
{
    return 0.5 * erfc(deviate * -0.70710678118654752440);
}

#endif
